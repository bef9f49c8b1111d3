#include <string.h>

#include "auto.h"
#include "gvcp_control.h"
#include "hw.h"
#include "stream.h"
#include "view_matrix.h"
#include "words.h"

#define FIRE (1u << 31)
#define PORTS_MAX 0xffffu

static bool receiver(struct receiver *to)
{
	if (!control.port || !control.address)
		return false;
	to->ip = control.address;
	to->port = control.port;
	to->packet_size = control.packet_size & 0xffff;
	to->delay_clocks = (uint32_t)((uint64_t)control.delay * CLOCK_HZ / 1000000000u);
	if (control.address >> 28 == 14) {		/* a multicast group */
		uint8_t mac[6] = {0x01, 0x00, 0x5e, control.address >> 16 & 0x7f,
				  control.address >> 8 & 0xff, control.address & 0xff};

		memcpy(to->mac.bytes, mac, 6);
		return true;
	}
	/* Pictures go to the controller's machine only. */
	to->mac = control.controller.mac;
	return control.address == control.controller.ip;
}

static uint32_t status_of(enum refusal refusal)
{
	switch (refusal) {
	case DONE: return SUCCESS;
	case BAD_VALUE: return INVALID_PARAMETER;
	case LOCKED: return ACCESS_DENIED;
	case READ_ONLY: return WRITE_PROTECT;
	case UNDER_WAY: return UNFINISHED;
	default: return DEVICE_ERROR;
	}
}

static uint32_t write_control(uint32_t value, const struct udp_path *peer)
{
	if (control.controlled && !control_is(peer))
		return ACCESS_DENIED;
	if (value & ~3u)
		return INVALID_PARAMETER;
	if (!value) {
		control_release();
		return SUCCESS;
	}
	control.controller = *peer;
	control.controlled = true;
	control.heard = now64();
	control.privilege = value;
	return SUCCESS;
}

static uint32_t write_packet_size(uint32_t value)
{
	struct receiver to;
	uint32_t size = value & 0xffff;

	if (size < PACKET_MIN || size > PACKET_MAX)
		return INVALID_PARAMETER;
	size = stream_packet_size(size);
	if (control.acquiring && size != (control.packet_size & 0xffff))
		return ACCESS_DENIED;
	control.packet_size = (value & PACKET_DO_NOT_FRAGMENT) | size;
	if (value & FIRE && receiver(&to))
		stream_test(&to, value & 0xffff);
	return SUCCESS;
}

static uint32_t write_bootstrap(uint32_t address, uint32_t value)
{
	uint32_t dummy;

	switch (address) {
	case BOOT_HeartbeatTimeout:
		control.heartbeat = value < HEARTBEAT_MIN_MS   ? HEARTBEAT_MIN_MS
				    : value > HEARTBEAT_MAX_MS ? HEARTBEAT_MAX_MS
							       : value;
		return SUCCESS;
	case BOOT_TimestampControl:
		if (value & 2)
			control.stamp = nanoseconds(now64());
		return SUCCESS;
	case BOOT_Configuration:
		if (value & ~GVCP_CONFIGURATION)
			return INVALID_PARAMETER;
		control.configuration = value;
		return SUCCESS;
	case BOOT_StreamPort:
		if (value > PORTS_MAX)
			return INVALID_PARAMETER;
		if (control.acquiring && value != control.port)
			return ACCESS_DENIED;
		control.port = value;
		return SUCCESS;
	case BOOT_StreamAddress:
		if (control.acquiring && value != control.address)
			return ACCESS_DENIED;
		control.address = value;
		return SUCCESS;
	case BOOT_StreamPacketDelay:
		if (value > PACKET_DELAY_MAX)
			return INVALID_PARAMETER;
		control.delay = value;
		return SUCCESS;
	case BOOT_StreamPacketSize:
		return write_packet_size(value);
	}
	return gvcp_read_word(address, &dummy) == INVALID_ADDRESS ? INVALID_ADDRESS : WRITE_PROTECT;
}

static uint32_t write_balance(const struct feature *one, uint32_t value)
{
	if (!AUTO_COLOUR)
		return WRITE_PROTECT;		/* the corrector has no sums of the colours */
	switch (one->id) {
	case FEATURE_BalanceWhiteAuto: automatic.balance = value; break;
	case FEATURE_BalanceRatioSelector: automatic.selector = value; break;
	case FEATURE_BalanceRatio:
		if (value == auto_ratio())
			break;
		if (automatic.balance)
			return ACCESS_DENIED;
		auto_set_ratio(value);
	}
	return SUCCESS;
}

static uint32_t write_own(const struct feature *one, uint32_t value)
{
	struct receiver to;

	if (!feature_takes(one, value))
		return INVALID_PARAMETER;
	switch (one->id) {
	case FEATURE_AcquisitionMode:
		if (control.acquiring)
			return ACCESS_DENIED;
		if (value > 1)
			return INVALID_PARAMETER;
		control.single = value;
		return SUCCESS;
	case FEATURE_ExposureAuto:
		automatic.exposure = value;
		return SUCCESS;
	case FEATURE_GainAuto:
		automatic.gain = value;
		return SUCCESS;
	case FEATURE_BalanceWhiteAuto: case FEATURE_BalanceRatioSelector: case FEATURE_BalanceRatio:
		return write_balance(one, value);
	case FEATURE_TriggerMode:
		if (control.acquiring && value != control.triggered)
			return ACCESS_DENIED;
		control.triggered = value;
		return SUCCESS;
	case FEATURE_TriggerSelector: case FEATURE_TriggerSource:
		return SUCCESS;			/* there is one choice */
	case FEATURE_TriggerSoftware:
		if (value)
			stream_trigger();
		return SUCCESS;
	case FEATURE_TLParamsLocked:
		control.tl_locked = value;
		words_streaming = value || control.acquiring;
		return SUCCESS;
	case FEATURE_AcquisitionStart:
		if (!value || control.acquiring)
			return SUCCESS;
		if (!receiver(&to))
			return ACCESS_DENIED;
		control.acquiring = words_streaming = true;
		stream_start(&to, control.single, control.triggered);
		return SUCCESS;
	case FEATURE_AcquisitionStop:
		if (value) {
			stream_stop();
			control.acquiring = false;
			words_streaming = control.tl_locked;
		}
		return SUCCESS;
	case FEATURE_SensorRegisterAddress:
		control.sensor_address = value;
		return SUCCESS;
	case FEATURE_SensorRegisterValue:
		return status_of(word_write(control.sensor_address, value));
	}
	return WRITE_PROTECT;
}

uint32_t gvcp_write_word(uint32_t address, uint32_t value, const struct udp_path *peer)
{
	const struct feature *one = feature_at(address);

	if (address % 4)
		return BAD_ALIGNMENT;
	if (address == BOOT_ControlPrivilege)
		return write_control(value, peer);
	if (!control_is(peer))
		return ACCESS_DENIED;
	if (address - GVCP_CORRECTOR_BASE < GVCP_CORRECTOR_BYTES) {
		if (!view_lets(address - GVCP_CORRECTOR_BASE, value))
			return UNFINISHED;
		reg_write(NCDC_BASE + (address - GVCP_CORRECTOR_BASE), value);
		return SUCCESS;
	}
	if (!one)
		return write_bootstrap(address, value);
	if (one->access == 'r')
		return WRITE_PROTECT;
	return !one->parts ? write_own(one, value) : status_of(feature_write(one, value));
}

#include <string.h>

#include "auto.h"
#include "eeprom.h"
#include "gvcp_control.h"
#include "hw.h"
#include "stream.h"
#include "words.h"

static const uint8_t XML[] = CONFIG_XML;

struct text {
	uint32_t address, length;
	const char *text;
};

static const struct text TEXTS[] = CONFIG_TEXTS;

static uint32_t text_word(const struct text *text, uint32_t offset)
{
	uint8_t bytes[4] = {0};
	uint32_t length = (uint32_t)strlen(text->text);

	for (uint32_t k = 0; k < 4 && offset + k < length; ++k)
		bytes[k] = (uint8_t)text->text[offset + k];
	return get32(bytes);
}

static uint32_t own_feature(const struct feature *one, uint32_t *value)
{
	switch (one->id) {
	case FEATURE_PayloadSize: *value = words_view().bytes; break;
	case FEATURE_AcquisitionMode: *value = control.single; break;
	case FEATURE_TriggerMode: *value = control.triggered; break;
	case FEATURE_TLParamsLocked: *value = control.tl_locked; break;
	case FEATURE_SensorRegisterAddress: *value = control.sensor_address; break;
	case FEATURE_ExposureAuto: *value = automatic.exposure; break;
	case FEATURE_GainAuto: *value = automatic.gain; break;
	case FEATURE_BalanceWhiteAuto: *value = automatic.balance; break;
	case FEATURE_BalanceRatioSelector: *value = automatic.selector; break;
	case FEATURE_BalanceRatio: *value = auto_ratio(); break;
	case FEATURE_SensorRegisterValue:
		return word_read(control.sensor_address, value) ? SUCCESS : UNFINISHED;
	}
	return SUCCESS;
}

static bool number(uint32_t address, uint32_t *value)
{
	switch (address) {
	case BOOT_Version: *value = 0x00010002; return true;
	case BOOT_DeviceMode: *value = 0x80000001; return true;
	case BOOT_MacHigh: *value = get16(ETH_OWN.bytes); return true;
	case BOOT_MacLow: *value = get32(ETH_OWN.bytes + 2); return true;
	case BOOT_IpOptions: *value = 6; return true;
	case BOOT_IpConfiguration: *value = 4; return true;
	case BOOT_IpAddress: *value = ip_own; return true;
	case BOOT_SubnetMask: *value = ip_mask; return true;
	case BOOT_NetworkInterfaces: case BOOT_StreamChannels: *value = 1; return true;
	case BOOT_Gateway: case BOOT_MessageChannels: case BOOT_TickFrequencyHigh:
	case BOOT_TimestampControl: *value = 0; return true;
	case BOOT_Capability: *value = GVCP_CAPABILITY; return true;
	case BOOT_Configuration: *value = control.configuration; return true;
	case BOOT_PendingTimeout: *value = GVCP_PENDING_MS; return true;
	case BOOT_HeartbeatTimeout: *value = control.heartbeat; return true;
	case BOOT_TickFrequencyLow: *value = 1000000000; return true;
	case BOOT_TimestampHigh: *value = (uint32_t)(control.stamp >> 32); return true;
	case BOOT_TimestampLow: *value = (uint32_t)control.stamp; return true;
	case BOOT_ControlPrivilege: *value = control.privilege; return true;
	case BOOT_StreamPort: *value = control.port; return true;
	case BOOT_StreamPacketSize: *value = control.packet_size; return true;
	case BOOT_StreamPacketDelay: *value = control.delay; return true;
	case BOOT_StreamAddress: *value = control.address; return true;
	case BOOT_StreamSourcePort: *value = STREAM_PORT; return true;
	case BOOT_EepromStatus: *value = eeprom_status; return true;
	}
	return false;
}

/* The word at an address; a status. */
uint32_t gvcp_read_word(uint32_t address, uint32_t *value)
{
	const struct feature *one;

	if (address % 4)
		return BAD_ALIGNMENT;
	/* First, as it is what clients keep asking for. */
	if (number(address, value))
		return SUCCESS;
	if (address - GVCP_XML_BASE < (sizeof XML + 3) / 4 * 4) {
		uint8_t bytes[4] = {0};
		uint32_t at = address - GVCP_XML_BASE;

		for (uint32_t k = 0; k < 4 && at + k < sizeof XML; ++k)
			bytes[k] = XML[at + k];
		*value = get32(bytes);
		return SUCCESS;
	}
	if (address - GVCP_CORRECTOR_BASE < GVCP_CORRECTOR_BYTES) {
		*value = reg_read(NCDC_BASE + (address - GVCP_CORRECTOR_BASE));
		return SUCCESS;
	}
	one = address >= GVCP_FEATURE_BASE ? feature_at(address) : 0;
	if (one) {
		if (!one->parts)
			return own_feature(one, value);
		*value = feature_read(one);
		return SUCCESS;
	}
	for (unsigned k = 0; k < sizeof TEXTS / sizeof *TEXTS; ++k)
		if (address - TEXTS[k].address < TEXTS[k].length) {
			*value = text_word(&TEXTS[k], address - TEXTS[k].address);
			return SUCCESS;
		}
	*value = 0;		/* reserved words of the discovery acknowledge */
	return address < GVCP_DISCOVERY_BYTES ? SUCCESS : INVALID_ADDRESS;
}

/* Writes `count` bytes of `size` that begin at `from`, and zeros after their end. */
static void copy(uint8_t *to, uint32_t count, const void *from, uint32_t size, uint32_t at)
{
	uint32_t there = at < size ? size - at : 0;

	if (there > count)
		there = count;
	memcpy(to, (const uint8_t *)from + (there ? at : 0), there);
	memset(to + there, 0, count - there);
}

/* Long texts go as a whole: word by word they would keep a client waiting. */
uint32_t gvcp_read_memory(uint32_t address, uint32_t count, uint8_t *to, uint32_t *done)
{
	if (address % 4)
		return BAD_ALIGNMENT;
	/* A client may read beyond the XML's end to fill its last packet. */
	if (address - GVCP_XML_BASE < sizeof XML) {
		copy(to, count, XML, sizeof XML, address - GVCP_XML_BASE);
		return SUCCESS;
	}
	for (unsigned k = 0; k < sizeof TEXTS / sizeof *TEXTS; ++k) {
		uint32_t at = address - TEXTS[k].address;

		if (at < TEXTS[k].length && count <= TEXTS[k].length - at) {
			copy(to, count, TEXTS[k].text, (uint32_t)strlen(TEXTS[k].text), at);
			return SUCCESS;
		}
	}
	for (; *done < count; *done += 4) {
		uint32_t value = 0, status = gvcp_read_word(address + *done, &value);

		if (status)
			return status;
		put32(to + *done, value);
	}
	return SUCCESS;
}

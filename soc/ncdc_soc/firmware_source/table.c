#include "table.h"

#include <string.h>

#include "hw.h"
#include "lwip/priv/tcp_priv.h"
#include "lwip/sys.h"
#include "mraw.h"
#include "words.h"

#define READ 0x80
#define WRITE 0x81
#define RESERVED 0x82		/* says nothing, is answered nothing */
#define UNKNOWN 0xff
#define MRAW 0x83
#define REQUEST 5		/* bytes of READ and WRITE, and of their answers */
#define LATER 60		/* bytes of requests that may wait */
#define UNTAKEN 3		/* lwIP's buffers with answers that a user has not taken */

struct user {
	struct tcp_pcb *pcb;	/* 0: the entry is free */
	uint8_t bytes[REQUEST];	/* of a request: not complete, or waiting for the sensor's bus */
	uint8_t count;
	bool written;		/* what it writes: the answer waits to be read back */
	uint16_t taken;		/* bytes of what lwIP offers, as long as the rest waits */
	uint8_t later[LATER];	/* what came while answers were not taken, or a package was sent */
	uint8_t waiting;	/* bytes of it */
	bool ends;		/* it will send nothing more */
	uint32_t heard_ms;	/* when its last request was answered */
	bool broken;		/* it has sent an unknown request: it is closed by the loop */
	struct mraw mraw;
};

uint32_t table_commands;
static struct user users[TABLE_USERS];
static unsigned connected;	/* entries in use */

static void vacate(struct user *user)
{
	mraw_forget(&user->mraw);
	user->pcb = 0;
	--connected;
}

static void leave(struct user *user)
{
	struct tcp_pcb *pcb = user->pcb;

	vacate(user);
	tcp_arg(pcb, 0);
	tcp_recv(pcb, 0);
	tcp_err(pcb, 0);
	tcp_poll(pcb, 0, 0);
	/* lwIP may forget it, if the other side does not end the connection, too. */
	tcp_setprio(pcb, TCP_PRIO_MIN);
	if (tcp_close(pcb) != ERR_OK)
		tcp_abort(pcb);
}

/* The request is complete and waits for the sensor's bus. */
static bool asks(const struct user *user)
{
	return user->pcb && user->count == REQUEST;
}

/* The word as this user sees it; false: it waits for the sensor's bus. */
static bool seen(const struct user *user, uint32_t address, uint32_t *value)
{
	if (address == WORD_NUMBER_UPPER)
		*value = user->mraw.number >> 16;
	else if (address == WORD_NUMBER_LOWER)
		*value = user->mraw.number & 0xffff;
	else
		return word_read(address, value);
	return true;
}

/* Answers the request, unless it has to wait; false if the connection is to be closed after it. */
static bool answer(struct user *user)
{
	uint8_t *bytes = user->bytes;
	uint32_t address = get16(bytes + 1), value;
	uint8_t unknown[2] = {UNKNOWN, bytes[0]};

	if (bytes[0] == WRITE && !user->written) {
		if (word_write(address, get16(bytes + 3)) == UNDER_WAY)
			return true;
		user->written = true;
	}
	if (asks(user) && !seen(user, address, &value))
		return true;
	++table_commands;
	user->heard_ms = sys_now();
	user->written = false;
	user->count = 0;
	if (bytes[0] == READ || bytes[0] == WRITE) {
		put16(bytes + 3, value);
		return tcp_write(user->pcb, bytes, REQUEST, TCP_WRITE_FLAG_COPY) == ERR_OK;
	}
	if (bytes[0] == MRAW) {
		user->mraw.state = MRAW_ASKED;
		return true;
	}
	tcp_write(user->pcb, unknown, sizeof unknown, TCP_WRITE_FLAG_COPY);
	return false;
}

/* Nothing is answered before the user has taken something: lwIP's buffers are for all. */
static bool full(const struct user *user)
{
	return tcp_sndqueuelen(user->pcb) >= UNTAKEN;
}

/* Takes a byte; false if the connection is to be closed. */
static bool take(struct user *user, uint8_t byte)
{
	if (user->mraw.state != MRAW_NONE || asks(user) || user->waiting || full(user)) {
		if (user->waiting == LATER)
			return false;
		user->later[user->waiting++] = byte;
		return true;
	}
	if (!user->count && byte == RESERVED)
		return true;
	user->bytes[user->count++] = byte;
	if (user->count == 1 && byte != READ && byte != WRITE)
		return answer(user);
	return user->count < REQUEST || answer(user);
}

static err_t received(void *argument, struct tcp_pcb *pcb, struct pbuf *chain, err_t error)
{
	struct user *user = argument;

	(void)error;
	for (; chain && !user->broken && user->taken < chain->tot_len; ++user->taken) {
		/* lwIP keeps the rest and offers it again, in `serve` or by its own clock. */
		if (asks(user)) {
			tcp_output(pcb);
			return ERR_MEM;
		}
		user->broken = !take(user, pbuf_get_at(chain, user->taken));
	}
	user->taken = 0;
	user->ends |= !chain;
	if (chain) {
		tcp_recved(pcb, chain->tot_len);
		pbuf_free(chain);
	}
	tcp_output(pcb);
	return ERR_OK;
}

static void failed(void *argument, err_t error)
{
	(void)error;
	vacate(argument);
}

/* More connections than this are not left half open: the oldest one goes. */
signed char table_incoming(struct tcp_pcb *pcb, unsigned flags)
{
	struct tcp_pcb *oldest = 0;
	unsigned count = 0;

	if (pcb->state != LISTEN || !(flags & TCP_SYN))
		return ERR_OK;
	/* The newest one comes first. */
	for (struct tcp_pcb *one = tcp_active_pcbs; one; one = one->next)
		if (one->state == SYN_RCVD) {
			++count;
			oldest = one;
		}
	if (count >= HALF_OPEN)
		tcp_abandon(oldest, 0);
	return ERR_OK;
}

/* A position for a new user: a free one, or that of who has been silent longest; 0: none. */
static struct user *position(void)
{
	struct user *oldest = 0;
	uint32_t silent = TABLE_IDLE_MS, now = sys_now();

	for (unsigned k = 0; k < TABLE_USERS; ++k) {
		struct user *user = &users[k];

		if (!user->pcb)
			return user;
		if (!asks(user) && user->mraw.state == MRAW_NONE && now - user->heard_ms >= silent) {
			silent = now - user->heard_ms;
			oldest = user;
		}
	}
	if (oldest)
		leave(oldest);
	return oldest;
}

static err_t accepted(void *argument, struct tcp_pcb *pcb, err_t error)
{
	struct user *user;

	(void)argument;
	if (error != ERR_OK || !pcb)
		return ERR_VAL;
	user = position();
	if (!user) {
		tcp_abort(pcb);
		return ERR_ABRT;
	}
	*user = (struct user){.pcb = pcb, .heard_ms = sys_now()};
	++connected;
	tcp_arg(pcb, user);
	tcp_recv(pcb, received);
	tcp_err(pcb, failed);
	ip_set_option(pcb, SOF_KEEPALIVE);
	tcp_nagle_disable(pcb);
	return ERR_OK;
}

/* Takes what has waited, up to the next request for a package. */
static bool take_waiting(struct user *user)
{
	uint8_t bytes[LATER], count = user->waiting, k = 0;

	memcpy(bytes, user->later, count);
	user->waiting = 0;
	for (; k < count; ++k)
		if (!take(user, bytes[k]))
			return false;
	return true;
}

/* Goes on with what the user waits for: an answer from the sensor, a package, and later requests.
 * False if the connection is to be closed. */
static bool serve(struct user *user)
{
	struct tcp_pcb *pcb = user->pcb;

	if (user->broken || (asks(user) && !answer(user)))
		return false;
	if (user->mraw.state == MRAW_SENDS) {
		if (!mraw_send(&user->mraw, pcb))
			return false;
		user->heard_ms = sys_now();
	}
	if (!asks(user) && user->mraw.state == MRAW_NONE && user->waiting && !full(user) &&
	    !take_waiting(user))
		return false;
	tcp_output(pcb);
	if (!asks(user) && user->mraw.state == MRAW_NONE && pcb->refused_data)
		tcp_process_refused_data(pcb);
	return asks(user) || user->mraw.state != MRAW_NONE || (user->waiting && !user->broken) ||
	       !(user->ends || user->broken);
}

/* Something is to be done for the user without a byte of theirs. */
static bool wanting(const struct user *user)
{
	return user->pcb && (user->mraw.state == MRAW_SENDS ||
			     (user->waiting && !full(user)) || user->ends || user->broken);
}

/* Begins packages that were asked for. A user who asks while a frame is sent waits until it is, and
 * all who have waited begin together. If new users could join, the frame might be held for ever. */
static void begin_packages(void)
{
	bool asked = false;

	for (unsigned k = 0; k < TABLE_USERS; ++k)
		asked |= users[k].mraw.state == MRAW_ASKED;
	if (asked && mraw_claim())
		for (unsigned k = 0; k < TABLE_USERS; ++k)
			if (users[k].mraw.state == MRAW_ASKED)
				mraw_begin(&users[k].mraw);
}

void table_poll(void)
{
	static unsigned first;
	bool served = false;

	/* A GVCP command waits for the loop: no time for users who are not there. */
	if (!connected)
		return;
	begin_packages();
	first = (first + 1) % TABLE_USERS;
	/* Each who waits for the sensor asks in each turn; of the others one is served. */
	for (unsigned k = 0; k < TABLE_USERS; ++k) {
		struct user *user = &users[(first + k) % TABLE_USERS];

		if (!asks(user) && (served || !wanting(user)))
			continue;
		served |= !asks(user);
		if (!serve(user))
			leave(user);
	}
}

int table_begin(void)
{
	struct tcp_pcb *pcb = tcp_new(), *listening;

	if (!pcb || tcp_bind(pcb, IP_ADDR_ANY, TABLE_PORT) != ERR_OK)
		return -1;
	listening = tcp_listen_with_backlog(pcb, 4);
	if (!listening)
		return -1;
	tcp_accept(listening, accepted);
	return 0;
}

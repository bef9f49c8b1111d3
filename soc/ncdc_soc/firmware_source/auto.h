/* Automatic exposure, gain and white balance, frame by frame while pictures stream. */
#ifndef AUTO_H
#define AUTO_H

#include <stdbool.h>
#include <stdint.h>

enum auto_mode { AUTO_OFF, AUTO_ONCE, AUTO_CONTINUOUS };

struct automatic {
	uint32_t exposure, gain, balance;	/* enum auto_mode */
	uint32_t selector;	/* colour that a ratio is of: red, green, blue */
};

extern struct automatic automatic;

struct exposure {
	uint32_t lines, gain;	/* eighths */
};

/* What the rule may change, and how far. */
struct limits {
	bool exposure, gain;
	uint32_t lines;
};

/* Settings of the next frames, by the mean of a frame in 16ths of a grey level and its settings; the
 * same ones if the rule has settled. As ncdc_spec.protocols.auto_control. */
struct exposure auto_exposed(uint32_t level, struct exposure now, const struct limits *limits);

/* Gains at capture of the next frames from the sums of `pixels` pixels, likewise; whether they
 * changed. The present gains are in the sums. */
bool auto_balanced(const uint32_t sums[3], uint32_t pixels, uint32_t gains[3]);

/* Whether the device alone writes that register of the sensor now. */
bool auto_locks(uint32_t address);

/* Whether it is writing exposure and gain: others' writes of them wait. */
bool auto_writes(void);

/* Gain at capture of the colour that is selected, in 256ths. */
uint32_t auto_ratio(void);
void auto_set_ratio(uint32_t gain);

void auto_poll(void);

#endif

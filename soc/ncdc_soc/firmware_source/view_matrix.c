#include "view_matrix.h"

#include "hw.h"

enum { PAN, TILT, ROLL, ZOOM, ANGLES };

#define ELEMENTS 9
#define QUARTER 9000		/* hundredths of a degree */
#define TERMS 7			/* of a series: the next one is below 2^-48 */
#define PART(n) (1.0 / ((n) * ((n) + 1)))
#define ZOOM_ONE 1000.0

struct turn {
	double cosine, sine;
};

/* Of the trained picture, in the corrector's registers: they come with each lens. */
struct camera {
	double focal, x, y, aspect;
};

static int32_t angles[ANGLES] = {[ZOOM] = (int32_t)ZOOM_ONE};
static int32_t matrix[ELEMENTS];	/* raw, as in the registers */
static bool waits;			/* it is not written yet */
static bool stale;			/* the lens is another one than it was made for */
static bool client_writes;		/* registers that it has not committed */

static uint32_t corrector_read(uint32_t offset)
{
	return reg_read(NCDC_BASE + offset);
}

static bool committed(void)
{
	return corrector_read(CORRECTOR_STATUS) & CORRECTOR_COMMITTED;
}

static int32_t camera_register(unsigned k)
{
	return (int32_t)corrector_read(CORRECTOR_CAMERA + 4 * k);
}

static struct camera camera(void)
{
	static const uint8_t FRACTIONS[] = CAMERA_FRACTIONS;
	double numbers[sizeof FRACTIONS];

	for (unsigned k = 0; k < sizeof FRACTIONS; ++k)
		numbers[k] = camera_register(k) / (double)(1ull << FRACTIONS[k]);
	return (struct camera){numbers[0], numbers[1], numbers[2], numbers[3]};
}

/* 1 - s / (n (n + 1)) (1 - s / ((n + 2) (n + 3)) (1 - ..)) */
static double series(double square, unsigned n)
{
	/* A quotient takes as long as four products. */
	static const double PARTS[] = {PART(1), PART(2), PART(3), PART(4), PART(5), PART(6), PART(7),
				       PART(8), PART(9), PART(10), PART(11), PART(12), PART(13),
				       PART(14)};
	double sum = 1;

	for (unsigned k = TERMS; k--;)
		sum = 1 - square * PARTS[n + 2 * k - 1] * sum;
	return sum;
}

/* Of an angle in hundredths of a degree. */
static struct turn turn_of(int32_t hundredths)
{
	int32_t half = hundredths < 0 ? -QUARTER / 2 : QUARTER / 2;
	int32_t quarters = (hundredths + half) / QUARTER;
	double x = (hundredths - QUARTER * quarters) * (VIEW_PI / (2 * QUARTER));
	double cosine = series(x * x, 1), sine = x * series(x * x, 2);

	switch (quarters & 3) {
	case 0: return (struct turn){cosine, sine};
	case 1: return (struct turn){-sine, cosine};
	case 2: return (struct turn){-cosine, -sine};
	default: return (struct turn){sine, -cosine};
	}
}

/* The real matrix from pixels of the view to those of the trained picture; of a lens that does not
 * state its camera, the trained picture. */
static void homography(const int32_t at[ANGLES], double h[3][3])
{
	struct camera c = camera();
	struct turn p = turn_of(at[PAN]), t = turn_of(at[TILT]), r = turn_of(at[ROLL]);
	double across = c.focal * at[ZOOM] / ZOOM_ONE, down = across * c.aspect;
	double turned[3][3] = {
		{p.cosine * r.cosine + p.sine * t.sine * r.sine,
		 p.sine * t.sine * r.cosine - p.cosine * r.sine, p.sine * t.cosine},
		{t.cosine * r.sine, t.cosine * r.cosine, -t.sine},
		{p.cosine * t.sine * r.sine - p.sine * r.cosine,
		 p.sine * r.sine + p.cosine * t.sine * r.cosine, p.cosine * t.cosine}};

	if (c.focal <= 0 || c.aspect <= 0) {
		for (unsigned k = 0; k < ELEMENTS; ++k)
			h[k / 3][k % 3] = k % 4 == 0;
		return;
	}
	for (unsigned k = 0; k < 3; ++k) {
		turned[k][0] /= across;
		turned[k][1] /= down;
		turned[k][2] -= c.x * turned[k][0] + c.y * turned[k][1];
	}
	for (unsigned k = 0; k < 3; ++k) {
		h[0][k] = c.focal * turned[0][k] + c.x * turned[2][k];
		h[1][k] = c.focal * c.aspect * turned[1][k] + c.y * turned[2][k];
		h[2][k] = turned[2][k];
	}
}

static double size_of(double value)
{
	return value < 0 ? -value : value;
}

/* What a register's number counts: 2^-f. */
static double unit(unsigned element)
{
	static const uint8_t FRACTIONS[ELEMENTS] = VIEW_FRACTIONS;

	return 1.0 / (double)(1ull << FRACTIONS[element]);
}

/* The largest depth at the outermost nodes. */
static double deepest(double h[3][3])
{
	static const int32_t COLUMNS[] = {VIEW_FIRST_NODE, VIEW_LAST_NODE};
	static const int32_t ROWS[] = {0, CORRECTED_HEIGHT - 1};
	double most = 0;

	for (unsigned k = 0; k < 4; ++k) {
		double depth = size_of(h[2][0] * COLUMNS[k & 1] + h[2][1] * ROWS[k >> 1] + h[2][2]);

		if (depth > most)
			most = depth;
	}
	return most;
}

/* The largest power of two by which the matrix fits the registers; 0: steps would not be precise. */
static double factor(double h[3][3])
{
	double depth = deepest(h), ratio = VIEW_DEPTH_MAX / depth, found = 1;

	for (unsigned k = 0; k < ELEMENTS; ++k) {
		double limit = INT32_MAX * unit(k), size = size_of(h[k / 3][k % 3]);

		if (size * ratio > limit)
			ratio = limit / size;
	}
	if (ratio * depth < VIEW_DEPTH_MIN)
		return 0;
	while (found > ratio)
		found /= 2;
	while (2 * found <= ratio)
		found *= 2;
	return found;
}

/* The nearest number of a register, half up. */
static int64_t rounded(double value, unsigned element)
{
	double units = value / unit(element) + 0.5;
	int64_t whole = (int64_t)units;

	return whole - ((double)whole > units);
}

static bool fits(int64_t number)
{
	return number == (int32_t)number;
}

/* Raw elements of the matrix; what the steps miss in the middle is added to the origins. */
static bool raw_matrix(const int32_t at[ANGLES], int32_t raw[ELEMENTS])
{
	static const int32_t MIDDLE[] = {(CORRECTED_WIDTH - 1) / 2, (CORRECTED_HEIGHT - 1) / 2};
	double h[3][3], scale;

	homography(at, h);
	scale = factor(h);
	if (scale == 0)
		return false;
	for (unsigned row = 0; row < 3; ++row) {
		double origin = h[row][2] * scale;

		for (unsigned k = 0; k < 3; ++k) {
			double value = k < 2 ? h[row][k] * scale : origin;
			int64_t number = rounded(value, 3 * row + k);

			if (!fits(number))
				return false;
			raw[3 * row + k] = (int32_t)number;
			if (k < 2)
				origin += (value - (double)number * unit(3 * row + k)) * MIDDLE[k];
		}
	}
	return true;
}

static void use(const int32_t raw[ELEMENTS])
{
	for (unsigned k = 0; k < ELEMENTS; ++k)
		matrix[k] = raw[k];
	waits = true;
}

/* A client has committed a lens, whose camera may be another one. If that cannot look so far, the
 * view is straight on, and so are the angles that clients read. */
static void renew(void)
{
	static const int32_t STRAIGHT[ANGLES] = {[ZOOM] = (int32_t)ZOOM_ONE};
	int32_t raw[ELEMENTS];

	if (!raw_matrix(angles, raw)) {
		if (!raw_matrix(STRAIGHT, raw))
			return;
		for (unsigned k = 0; k < ANGLES; ++k)
			angles[k] = STRAIGHT[k];
	}
	use(raw);
}

uint32_t view_focal(void)
{
	uint64_t focal = HAS_VIEW ? (uint32_t)camera_register(0) : 0;

	return (uint32_t)((FOCAL_STEPS * focal + (1u << (FOCAL_FRACTION - 1))) >> FOCAL_FRACTION);
}

uint32_t view_read(uint32_t address)
{
	return HAS_VIEW ? (uint32_t)angles[address - WORD_PAN] & 0xffff : 0;
}

enum refusal view_write(uint32_t address, uint32_t value)
{
	static const int32_t LOW[] = VIEW_LOW, HIGH[] = VIEW_HIGH;
	int32_t wanted[ANGLES], raw[ELEMENTS];
	unsigned which = address - WORD_PAN;

	if (!HAS_VIEW)
		return READ_ONLY;
	for (unsigned k = 0; k < ANGLES; ++k)
		wanted[k] = angles[k];
	wanted[which] = (int16_t)value;
	if (wanted[which] < LOW[which] || wanted[which] > HIGH[which] || !raw_matrix(wanted, raw))
		return BAD_VALUE;
	angles[which] = wanted[which];
	use(raw);
	return DONE;
}

void view_renew(void)
{
	stale = true;
}

void view_poll(void)
{
	if (!HAS_VIEW || !(waits || stale) || client_writes || committed())
		return;
	if (stale)
		renew();
	waits = stale = false;
	for (unsigned k = 0; k < ELEMENTS; ++k)
		reg_write(NCDC_BASE + CORRECTOR_VIEW + 4 * k, (uint32_t)matrix[k]);
	reg_write(NCDC_BASE + CORRECTOR_CTRL, CORRECTOR_COMMIT);
}

bool view_lets(uint32_t offset, uint32_t value)
{
	if (!HAS_VIEW || offset == CORRECTOR_STATUS)
		return true;
	if (offset == CORRECTOR_CTRL) {
		if (value & CORRECTOR_COMMIT) {
			client_writes = false;
			view_renew();
		}
		return true;
	}
	/* The corrector ignores what is written to a set that is committed. */
	if (!client_writes && committed())
		return false;
	client_writes = true;
	return true;
}

void view_forget_client(void)
{
	client_writes = false;
}

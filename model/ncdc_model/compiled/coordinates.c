/* Coordinates of the integer network, as ncdc_model.golden.network and .nodes define them.
 *
 * Integers only, so that every order of evaluation gives the same bits. Each loop is over a few
 * hundred columns of a row: the compiler makes vector instructions of it.
 */
#include <stdint.h>

#define CHUNK 256               /* columns at a time: what lies between stays in the cache */

enum {MMHBC, CLASSIC, TABLE};   /* ncdc_model.compiled.coordinates has the same numbers */

struct tansig {                 /* parameters of one ncdc_spec.tansig.Design */
    int32_t variant;
    int32_t input_bits;         /* fraction bits of the net */
    int32_t largest;            /* magnitude of the net */
    int32_t width;              /* fraction bits of the exponential */
    int32_t digits;             /* of the quotient */
    int32_t steps;              /* rotations; of the table: ranges */
    const int32_t *shifts;      /* of each rotation */
    const int32_t *angles;      /* of each rotation (classic) */
    int32_t start;              /* first cosh (classic) */
    int32_t fine_bits;          /* of the net below the region (mmhbc) */
    const int32_t *table;       /* exponentials by region, or by integer part */
    const int32_t *ranges;      /* first entry, first magnitude, log2 of the width (table) */
    const int64_t *segments;    /* value, slope, curvature (table) */
    int32_t position_bits, slope_bits, offset_bits, fraction_bits;      /* table */
};

struct layers {                 /* the network: weights with the shifts that align their products */
    int32_t neurons;
    int32_t net_shift, net_low, net_high;
    int32_t shift, low, high;   /* of a coordinate */
    const int64_t *hidden;      /* of each neuron: weights of x and y, bias */
    const int64_t *output;      /* of x', then of y': bias, weights of x and y, of the neurons */
};

static inline int64_t requantised(int64_t raw, int shift, int64_t low, int64_t high)
{
    int64_t value = (raw + ((int64_t)1 << (shift - 1))) >> shift;
    return value < low ? low : value > high ? high : value;
}

static inline int32_t round_shift(int32_t value, int shift)
{
    return (value + (1 << (shift - 1))) >> shift;
}

/* (1 - u) / (1 + u) in place, by digits +-2^-i. */
static void quotient(const struct tansig *t, int32_t *u, int count)
{
    int32_t remainder[CHUNK], divisor[CHUNK];
    const int32_t one = 1 << t->width, first = 1 << (t->digits - 1);
    for (int k = 0; k < count; k++) {
        divisor[k] = one + u[k];
        remainder[k] = one - u[k] - round_shift(divisor[k], 1);
        u[k] = first;
    }
    for (int i = 2; i <= t->digits; i++) {
        const int32_t digit = 1 << (t->digits - i);
        for (int k = 0; k < count; k++) {
            int32_t step = round_shift(divisor[k], i), minus = remainder[k] >> 31;
            remainder[k] -= (step ^ minus) - minus;
            u[k] += (digit ^ minus) - minus;
        }
    }
}

static void mmhbc(const struct tansig *t, const int32_t *a, int32_t *u, int count)
{
    for (int k = 0; k < count; k++)
        u[k] = t->table[a[k] >> t->fine_bits];
    for (int i = 0; i < t->steps; i++) {
        const int shift = t->shifts[i], bit = t->fine_bits - 1 - i;
        for (int k = 0; k < count; k++) {
            int32_t minus = -(a[k] >> bit & 1), step = round_shift(u[k], shift);
            u[k] += (step ^ minus) - minus;
        }
    }
    quotient(t, u, count);
}

static void classic(const struct tansig *t, const int32_t *a, int32_t *u, int count)
{
    for (int k = 0; k < count; k++) {
        int32_t z = -((a[k] & ((1 << t->input_bits) - 1)) << (t->width - t->input_bits));
        int32_t x = t->start, y = 0;
        for (int i = 0; i < t->steps; i++) {
            int32_t dx = round_shift(y, t->shifts[i]), dy = round_shift(x, t->shifts[i]);
            int minus = i == 0 || z < 0;
            x += minus ? -dx : dx;
            y += minus ? -dy : dy;
            z += minus ? t->angles[i] : -t->angles[i];
        }
        int64_t product = (int64_t)t->table[a[k] >> t->input_bits] * (x + y);
        u[k] = (product + ((int64_t)1 << (t->width - 1))) >> t->width;
    }
    quotient(t, u, count);
}

static void quadratics(const struct tansig *t, const int32_t *a, int32_t *u, int count)
{
    const int below = t->slope_bits + t->position_bits;
    const int64_t limit = ((int64_t)1 << t->fraction_bits) - 1;
    for (int k = 0; k < count; k++) {
        const int32_t *range = t->ranges;
        for (int i = 1; i < t->steps; i++)
            if (a[k] >= t->ranges[3 * i + 1])
                range = t->ranges + 3 * i;
        const int64_t *segment = t->segments + 3 * (range[0] + ((a[k] - range[1]) >> range[2]));
        int64_t position = (int64_t)(a[k] & ((1 << range[2]) - 1)) << (t->position_bits - range[2]);
        int64_t steepness = segment[1] - (segment[2] * position >> t->position_bits);
        int64_t value = ((segment[0] << (below - t->offset_bits)) + position * steepness)
                        >> (below - t->fraction_bits);
        u[k] = 2 * (value < limit ? value : limit) + 1;
    }
}

/* The tan-sigmoid of each net, in place. */
static void tansig(const struct tansig *t, int32_t *net, int count)
{
    int32_t a[CHUNK], u[CHUNK];
    for (int k = 0; k < count; k++) {
        int32_t magnitude = net[k] < 0 ? -net[k] : net[k];
        a[k] = magnitude < t->largest ? magnitude : t->largest;
    }
    if (t->variant == MMHBC)
        mmhbc(t, a, u, count);
    else if (t->variant == CLASSIC)
        classic(t, a, u, count);
    else
        quadratics(t, a, u, count);
    for (int k = 0; k < count; k++)
        net[k] = net[k] < 0 ? -u[k] : net[k] > 0 ? u[k] : 0;
}

/* The network at up to CHUNK points. */
static void network_chunk(const struct layers *l, const struct tansig *t, const int64_t *x,
                          const int64_t *y, int count, int32_t *restrict out_x,
                          int32_t *restrict out_y)
{
    const int64_t *of_x = l->output, *of_y = l->output + 3 + l->neurons;
    int64_t sum_x[CHUNK], sum_y[CHUNK];
    int32_t net[CHUNK];
    for (int k = 0; k < count; k++) {
        sum_x[k] = of_x[0] + of_x[1] * x[k] + of_x[2] * y[k];
        sum_y[k] = of_y[0] + of_y[1] * x[k] + of_y[2] * y[k];
    }
    for (int n = 0; n < l->neurons; n++) {
        const int64_t *w = l->hidden + 3 * n;
        for (int k = 0; k < count; k++)
            net[k] = requantised(w[0] * x[k] + w[1] * y[k] + w[2], l->net_shift, l->net_low,
                                 l->net_high);
        tansig(t, net, count);
        for (int k = 0; k < count; k++) {
            sum_x[k] += of_x[3 + n] * net[k];
            sum_y[k] += of_y[3 + n] * net[k];
        }
    }
    for (int k = 0; k < count; k++) {
        out_x[k] = requantised(sum_x[k], l->shift, l->low, l->high);
        out_y[k] = requantised(sum_y[k], l->shift, l->low, l->high);
    }
}

/* The network at any points. */
void network(const struct layers *l, const struct tansig *t, const int64_t *x, const int64_t *y,
             long points, int32_t *restrict out_x, int32_t *restrict out_y)
{
    for (long k = 0; k < points; k += CHUNK)
        network_chunk(l, t, x + k, y + k, points - k < CHUNK ? points - k : CHUNK, out_x + k,
                      out_y + k);
}

/* Coordinates between the nodes of each row, `step` pixels apart; the first is at -step. */
void between_nodes(const int32_t *nodes, int count, int step, int rows, int width, int shift,
                   int32_t low, int32_t high, int32_t *restrict out)
{
    for (int v = 0; v < rows; v++, nodes += count, out += width)
        for (int u = 0; u < width; u++) {
            const int32_t *p = nodes + u / step;
            const int64_t j = u % step;
            int64_t bend = ((int64_t)p[3] - p[2]) - ((int64_t)p[1] - p[0]);
            int64_t line = step * (int64_t)p[1] + j * ((int64_t)p[2] - p[1]);
            out[u] = requantised(4 * step * line - j * (step - j) * bend, shift, low, high);
        }
}

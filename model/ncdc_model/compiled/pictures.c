/* Corrected pictures, as ncdc_model.golden.picture, .directional and .corrector define them.
 *
 * What depends on samples alone is computed once a frame, at every sample; then each pixel blends
 * what is at its four corners. Integers only: the sums are exact in any order.
 *
 * `raw` is a frame with MARGIN mirrored samples on every side, or none where it says so; `width`
 * and `height` are the frame's without them. What is at a sample, or at the quad that begins there,
 * has the index y * width + x. (red_column, red_row) is the parity of the red samples.
 */
#include <stdint.h>
#include <string.h>

#define MARGIN 2                /* of the interpolations with windows of 6x6 samples */
#define DROPPED 2               /* lowest bits of a sample that the decision ignores */
#define BIAS 8                  /* by which one direction must be better */
#define BATCH 64                /* pixels that are blended at a time */

struct source {                 /* where a corrected pixel comes from */
    int32_t corner;             /* 4 at + 2 below + right, see at(); below zero: blank */
    int32_t fx, fy;             /* fractions after the first corner */
};

/* Sources of a row of pixels from their coordinates, see golden.picture.window_address. */
void sources(const int32_t *x, const int32_t *y, const uint8_t *valid, int count, int offset,
             int f_bits, int core, int width, int height, int red_column, int red_row,
             struct source *out)
{
    const int32_t last = (1 << f_bits) - 1;
    const int32_t end[2] = {width - core + 1, height - core + 1};
    for (int k = 0; k < count; k++) {
        const int64_t shifted[2] = {(int64_t)x[k] - offset, (int64_t)y[k] - offset};
        int32_t origin[2], fraction[2], inside = valid[k];
        for (int axis = 0; axis < 2; axis++) {
            origin[axis] = shifted[axis] >> f_bits;
            fraction[axis] = shifted[axis] & last;
            inside &= origin[axis] >= -1 && origin[axis] <= end[axis];
            if (origin[axis] == -1)
                origin[axis] = fraction[axis] = 0;
            if (origin[axis] == end[axis]) {
                origin[axis]--;
                fraction[axis] = last;
            }
        }
        const int32_t at = origin[1] * width + origin[0];
        const int32_t right = (origin[0] + red_column) & 1, below = (origin[1] + red_row) & 1;
        out[k] = (struct source){inside ? 4 * at + 2 * below + right : -1, fraction[0],
                                 fraction[1]};
    }
}

/* Colours of the quad of 2x2 samples from each one on, in halves; the fourth one is not used.
 * `raw` has no margin. */
void fast_colours(const uint8_t *restrict raw, int width, int height, int red_column, int red_row,
                  int16_t (*restrict out)[4])
{
    for (int y = 0; y < height - 1; y++) {
        const uint8_t *upper = raw + (long)y * width, *lower = upper + width;
        int16_t (*colours)[4] = out + (long)y * width;
        for (int x = 0; x < width - 1; x++) {
            const int right = (x + red_column) & 1, below = (y + red_row) & 1;
            const uint8_t *red = below ? lower : upper, *blue = below ? upper : lower;
            colours[x][0] = 2 * red[x + right];
            colours[x][1] = red[x + 1 - right] + blue[x + right];
            colours[x][2] = 2 * blue[x + 1 - right];
            colours[x][3] = 0;
        }
    }
}

/* Three times each sample, in sixteenths: a grey sensor's colours. */
void grey_colours(const uint8_t *restrict raw, int width, int height, int16_t (*restrict out)[4])
{
    const int stride = width + 2 * MARGIN;
    for (int y = 0; y < height; y++) {
        const uint8_t *at = raw + (long)(y + MARGIN) * stride + MARGIN;
        int16_t (*colours)[4] = out + (long)y * width;
        for (int x = 0; x < width; x++)
            colours[x][0] = colours[x][1] = colours[x][2] = colours[x][3] = 16 * at[x];
    }
}

/* Sums of the samples around the one at c, named as in golden.directional. */
#define LEFT_RIGHT(c, s) ((c)[-1] + (c)[1])
#define ABOVE_BELOW(c, s) ((c)[-(s)] + (c)[s])
#define FAR_ROW(c, s) ((c)[-2] + (c)[2])
#define FAR_COLUMN(c, s) ((c)[-2 * (s)] + (c)[2 * (s)])
#define CORNERS(c, s) ((c)[-(s) - 1] + (c)[-(s) + 1] + (c)[(s) - 1] + (c)[(s) + 1])
#define TALL(c, s) ((c)[-2 * (s) - 1] + (c)[-2 * (s) + 1] + (c)[2 * (s) - 1] + (c)[2 * (s) + 1])
#define WIDE(c, s) ((c)[-(s) - 2] + (c)[-(s) + 2] + (c)[(s) - 2] + (c)[(s) + 2])

/* Colours at each sample by gradient-corrected kernels, in sixteenths. */
void gradient_colours(const uint8_t *restrict raw, int width, int height, int red_column,
                      int red_row, int16_t (*restrict out)[4])
{
    const int stride = width + 2 * MARGIN;
    for (int y = 0; y < height; y++) {
        const int in_red_row = !((y + red_row) & 1);
        const uint8_t *row = raw + (long)(y + MARGIN) * stride + MARGIN;
        int16_t (*colours)[4] = out + (long)y * width;
        for (int x = 0; x < width; x++) {
            const uint8_t *c = row + x;
            const int h = LEFT_RIGHT(c, stride), v = ABOVE_BELOW(c, stride);
            const int q = FAR_ROW(c, stride), p = FAR_COLUMN(c, stride), d = CORNERS(c, stride);
            const int own = 16 * c[0], in_red_column = !((x + red_column) & 1);
            const int is_green = in_red_row != in_red_column;
            const int green = 8 * c[0] + 4 * (h + v) - 2 * (q + p);
            const int other = 12 * c[0] + 4 * d - 3 * (q + p);
            const int across = 10 * c[0] + 8 * h - 2 * d - 2 * q + p;
            const int down = 10 * c[0] + 8 * v - 2 * d - 2 * p + q;
            const int of_row = is_green ? across : own, of_column = is_green ? down : other;
            colours[x][0] = in_red_row ? of_row : of_column;
            colours[x][1] = is_green ? own : green;
            colours[x][2] = in_red_row ? of_column : of_row;
            colours[x][3] = 0;
        }
    }
}

/* What the directional colours of each sample are made from, in sixteenths:
 * at red and blue: green and the other colour without direction, e, the own colour;
 * at green: a + b and a - b of the row's colour, a + b and a - b of the column's. */
void directional_terms(const uint8_t *restrict raw, int width, int height, int red_column,
                       int red_row, int16_t (*restrict out)[4])
{
    const int stride = width + 2 * MARGIN;
    for (int y = 0; y < height; y++) {
        const uint8_t *row = raw + (long)(y + MARGIN) * stride + MARGIN;
        int16_t (*terms)[4] = out + (long)y * width;
        for (int x = 0; x < width; x++) {
            const uint8_t *c = row + x;
            const int h = LEFT_RIGHT(c, stride), v = ABOVE_BELOW(c, stride);
            const int q = FAR_ROW(c, stride), p = FAR_COLUMN(c, stride), d = CORNERS(c, stride);
            const int is_green = (x + red_column + y + red_row) & 1;
            const int t = 4 * c[0] - p - q;
            const int a = 4 * h + 2 * c[0] - q, a_down = 4 * v + 2 * c[0] - p;
            const int b = 8 * c[0] + 2 * h + TALL(c, stride) - 2 * d;
            const int b_down = 8 * c[0] + 2 * v + WIDE(c, stride) - 2 * d;
            terms[x][0] = is_green ? a + b : 4 * (h + v) + t + (t >> 1);
            terms[x][1] = is_green ? a - b : 4 * d + 2 * t;
            terms[x][2] = is_green ? a_down + b_down : 3 * (h - v) - (q - p);
            terms[x][3] = is_green ? a_down - b_down : 16 * c[0];
        }
    }
}

static inline int second_difference(const uint8_t *c, long step)
{
    return (c[0] >> DROPPED) - (c[step] >> DROPPED) - (c[2 * step] >> DROPPED)
           + (c[3 * step] >> DROPPED);
}

/* m(d) of the four samples in line from each one on, along rows and along columns, of a frame with
 * its margin; both results have its shape. */
void variations(const uint8_t *restrict raw, int width, int height, uint8_t *restrict along,
                uint8_t *restrict down)
{
    const int stride = width + 2 * MARGIN, rows = height + 2 * MARGIN;
    for (int y = 0; y < rows; y++, raw += stride, along += stride, down += stride) {
        for (int x = 0; x < stride - 3; x++) {
            int d = second_difference(raw + x, 1);
            along[x] = d ^ d >> 31;
        }
        if (y < rows - 3)
            for (int x = 0; x < stride; x++) {
                int d = second_difference(raw + x, stride);
                down[x] = d ^ d >> 31;
            }
    }
}

/* 2 s of each quad, from the variations. */
void directions(const uint8_t *restrict along, const uint8_t *restrict down, int width, int height,
                int8_t *restrict out)
{
    const int s = width + 2 * MARGIN;
    for (int y = 0; y < height - 1; y++, along += s, down += s, out += width)
        for (int x = 0; x < width - 1; x++) {
            const uint8_t *a = along + x, *b = down + x;
            int h = a[s + 1] + a[2 * s] + a[2 * s + 1] + a[2 * s + 2]
                    + a[3 * s] + a[3 * s + 1] + a[3 * s + 2] + a[4 * s + 1];
            int v = b[s + 1] + b[2] + b[s + 2] + b[2 * s + 2]
                    + b[3] + b[s + 3] + b[2 * s + 3] + b[s + 4];
            int rowwise = 2 * h + BIAS <= v ? 2 : 4 * h + BIAS <= 3 * v;
            int columnwise = 2 * v + BIAS <= h ? 2 : 4 * v + BIAS <= 3 * h;
            out[x] = rowwise - columnwise;
        }
}

/* The middle second differences of each quad, along rows and along columns. */
void curvatures(const uint8_t *restrict raw, int width, int height, int16_t (*restrict out)[2])
{
    const int stride = width + 2 * MARGIN;
    for (int y = 0; y < height - 1; y++) {
        const uint8_t *row = raw + (long)(y + MARGIN) * stride + MARGIN;
        int16_t (*quads)[2] = out + (long)y * width;
        for (int x = 0; x < width - 1; x++) {
            const uint8_t *c = row + x;
            quads[x][0] = second_difference(c - 1, 1) + second_difference(c - 1 + stride, 1);
            quads[x][1] = second_difference(c - stride, stride)
                          + second_difference(c - stride + 1, stride);
        }
    }
}

struct blending {               /* what all pixels of a frame share */
    int32_t f_bits;             /* of a position between the corners */
    int32_t unit_bits;          /* of the corners' colours */
    int32_t cut;                /* lowest bits that colours between the corners of a row lose */
    int32_t width;              /* of the raw frame */
    int32_t strength;           /* of the crest */
    const int16_t (*curvature)[2];      /* NULL without a crest */
    uint8_t fill[4];
};

/* The weight of the crest at a fraction. */
static inline int crest_weight(int32_t fraction, int f_bits)
{
    static const int8_t weight[8] = {0, 1, 2, 2, 3, 3, 4, 4};
    const int32_t upper = -(fraction >> (f_bits - 1));
    return weight[(int64_t)((fraction ^ upper) & ((1 << f_bits) - 1)) << 4 >> f_bits];
}

/* Index of the first corner of a pixel; of a blank one 0, so that it can be computed as others. */
static inline int32_t at(const struct source *s)
{
    return s->corner < 0 ? 0 : s->corner >> 2;
}

static inline int32_t crest(const struct blending *b, const struct source *s)
{
    if (!b->curvature)
        return 0;
    const int16_t *curvature = b->curvature[at(s)];
    return -b->strength * (crest_weight(s->fx, b->f_bits) * curvature[0]
                           + crest_weight(s->fy, b->f_bits) * curvature[1]);
}

struct batch {                  /* pixels on their way: vector instructions blend them */
    int32_t fx[BATCH], fy[BATCH], crest[BATCH];
    int32_t colour[3][4][BATCH];        /* of the corners: upper left, upper right, lower ones */
};

/* Blend the corners of a batch, add the crest, round, clamp, store. */
static void finish(const struct blending *b, const struct batch *from, const struct source *s,
                   int count, uint8_t (*restrict out)[3])
{
    const int f_bits = b->f_bits, cut = b->cut, shift = 2 * f_bits + b->unit_bits - cut;
    const int64_t half = (int64_t)1 << (shift - 1);
    uint8_t plane[3][BATCH];
    for (int k = 0; k < 3; k++) {
        const int32_t *ul = from->colour[k][0], *ur = from->colour[k][1];
        const int32_t *ll = from->colour[k][2], *lr = from->colour[k][3];
        for (int n = 0; n < BATCH; n++) {
            const int64_t fx = from->fx[n], fy = from->fy[n];
            const int64_t upper = (((int64_t)ul[n] << f_bits) + fx * (ur[n] - ul[n])) >> cut;
            const int64_t lower = (((int64_t)ll[n] << f_bits) + fx * (lr[n] - ll[n])) >> cut;
            const int64_t total = ((upper + from->crest[n]) << f_bits) + fy * (lower - upper);
            const int64_t value = (total + half) >> shift;
            plane[k][n] = value < 0 ? 0 : value > 255 ? 255 : value;
        }
    }
    for (int n = 0; n < count; n++)
        for (int k = 0; k < 3; k++)
            out[n][k] = s[n].corner < 0 ? b->fill[k] : plane[k][n];
}

/* Pixels between the colours of their four corners. */
void blend(const struct blending *b, const struct source *s, int count,
           const int16_t (*restrict colours)[4], uint8_t (*restrict out)[3])
{
    struct batch batch = {0};
    int16_t around[4][BATCH][4] = {0};
    for (int left = 0; left < count; left += BATCH, s += BATCH, out += BATCH) {
        const int pixels = count - left < BATCH ? count - left : BATCH;
        for (int n = 0; n < pixels; n++) {
            const int16_t (*upper)[4] = colours + at(s + n), (*lower)[4] = upper + b->width;
            memcpy(around[0][n], upper[0], sizeof *upper);
            memcpy(around[1][n], upper[1], sizeof *upper);
            memcpy(around[2][n], lower[0], sizeof *upper);
            memcpy(around[3][n], lower[1], sizeof *upper);
            batch.fx[n] = s[n].fx;
            batch.fy[n] = s[n].fy;
            batch.crest[n] = crest(b, s + n);
        }
        for (int j = 0; j < 4; j++)
            for (int n = 0; n < BATCH; n++)
                for (int k = 0; k < 3; k++)
                    batch.colour[k][j][n] = around[j][n][k];
        finish(b, &batch, s, pixels, out);
    }
}

/* s times a value, for 2 s. */
static inline int times(int twice, int value)
{
    return (twice * value + (twice == -1)) >> 1;
}

/* The same between the directional colours: one direction for the four corners of a pixel. The
 * corners are taken by their colour, and the fractions reflected with them. `raw` has no margin. */
void blend_directional(const struct blending *b, const struct source *s, int count,
                       const int16_t (*restrict terms)[4], const uint8_t *restrict raw,
                       const int8_t *restrict direction, uint8_t (*restrict out)[3])
{
    const int32_t one = 1 << b->f_bits;
    struct batch batch = {0};
    int16_t red[BATCH][4] = {0}, red_row[BATCH][4] = {0};
    int16_t blue_row[BATCH][4] = {0}, blue[BATCH][4] = {0};
    int32_t twice[BATCH] = {0}, green_red[BATCH] = {0}, green_blue[BATCH] = {0};
    for (int left = 0; left < count; left += BATCH, s += BATCH, out += BATCH) {
        const int pixels = count - left < BATCH ? count - left : BATCH;
        for (int n = 0; n < pixels; n++) {
            const int right = s[n].corner & 1, below = s[n].corner >> 1 & 1;
            const int32_t first = at(s + n);
            const int32_t row = first + below * b->width, other = first + (1 - below) * b->width;
            memcpy(red[n], terms[row + right], sizeof *terms);
            memcpy(red_row[n], terms[row + 1 - right], sizeof *terms);
            memcpy(blue_row[n], terms[other + right], sizeof *terms);
            memcpy(blue[n], terms[other + 1 - right], sizeof *terms);
            green_red[n] = raw[row + 1 - right];
            green_blue[n] = raw[other + right];
            twice[n] = direction[first];
            batch.fx[n] = right ? one - s[n].fx : s[n].fx;
            batch.fy[n] = below ? one - s[n].fy : s[n].fy;
            batch.crest[n] = crest(b, s + n);
        }
        for (int n = 0; n < BATCH; n++) {
            const int16_t *r = red[n], *g = red_row[n], *h = blue_row[n], *l = blue[n];
            const int at_red = times(twice[n], r[2]), at_blue = times(twice[n], l[2]);
            batch.colour[0][0][n] = r[3];
            batch.colour[0][1][n] = g[0] + times(twice[n], g[1]);
            batch.colour[0][2][n] = h[2] + times(-twice[n], h[3]);
            batch.colour[0][3][n] = l[1] + 2 * at_blue;
            batch.colour[1][0][n] = r[0] + at_red;
            batch.colour[1][1][n] = 16 * green_red[n];
            batch.colour[1][2][n] = 16 * green_blue[n];
            batch.colour[1][3][n] = l[0] + at_blue;
            batch.colour[2][0][n] = r[1] + 2 * at_red;
            batch.colour[2][1][n] = g[2] + times(-twice[n], g[3]);
            batch.colour[2][2][n] = h[0] + times(twice[n], h[1]);
            batch.colour[2][3][n] = l[3];
        }
        finish(b, &batch, s, pixels, out);
    }
}

/* Steps of Levenberg-Marquardt as ncdc_model.training.varpro defines them, bit by bit.
 *
 * Sums of cut numbers are exact; every other operation is the reference's, in its order. So no
 * multiplication may be fused with an addition here (the library's flags): see products.c.
 */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define SLICES 2                /* of the hidden outputs, at most */
#define TINY 1e-14              /* of the diagonal: a smaller pivot is a rounding error */
#define MAX_DAMPING 1e10
#define MAX_GROWTH 64.
#define ALIGNED 64              /* bytes */

struct points {                 /* rows of `stride` numbers, zeros after the first `count` */
    int32_t neurons, linear, slices, count, stride, half;       /* half: of the table */
    double ridge, reach, per_entry;                             /* per_entry: 1 / step of it */
    const double *fan;          /* x, y, 1 */
    const double *constant;     /* slices of the linear terms: (slices, linear, stride) */
    const double *targets;      /* (2, stride) */
    const double *target_slices;        /* (slices, 2, stride) */
    const double *limit;        /* of the weights of x and y and of the bias */
    const double *table;        /* tanh of multiples of 1 / per_entry */
};

struct state {                  /* of one network */
    double *hidden;             /* (slices, terms, stride) */
    double *gram;               /* (terms, terms) */
    double *output;             /* (terms, 2) */
    double *residual;           /* (2, stride) */
    double cost;
};

struct work {
    double *derivative, *residual, *squares, *joint, *matrix, *normal, *gradient, *move, *trial;
};

void add_products(double *out, int pitch, const double *a, int rows, const double *b, int columns,
                  int stride, int half);

static int terms_of(const struct points *p)
{
    return p->neurons + p->linear;
}

static double cut(double value, double scale)
{
    const double large = 1.5 * 2147483648.0 * scale;
    return (value + large) - large;
}

static double scale_of(const double *values, int count)
{
    double largest = 0;
    int exponent;
    for (int k = 0; k < count; k++)
        largest = fabs(values[k]) > largest ? fabs(values[k]) : largest;
    const double mantissa = frexp(largest, &exponent);
    return ldexp(1.0, exponent - (mantissa <= .7));
}

/* Sum by halves; the values are lost. */
static double total(double *values, int count)
{
    while (count > 1) {
        const int half = (count + 1) / 2;
        for (int k = 0; k < count - half; k++)
            values[k] += values[half + k];
        count = half;
    }
    return values[0];
}

/* Sets out (rows, columns) to the products of slices, coarse ones last, as exact.products.
 *
 * Of one slice by itself only the upper half is computed.
 */
static void products(const struct points *p, double *out, int pitch, const double *a, int a_slices,
                     int rows, const double *b, int b_slices, int columns)
{
    const int depth = a_slices > b_slices ? a_slices : b_slices;
    for (int i = 0; i < rows; i++)
        memset(out + i * pitch, 0, columns * sizeof(double));
    for (int level = depth - 1; level >= 0; level--)
        for (int i = 0; i < a_slices; i++)
            if (level - i >= 0 && level - i < b_slices)
                add_products(out, pitch, a + (size_t)i * rows * p->stride, rows,
                             b + (size_t)(level - i) * columns * p->stride, columns, p->stride, a == b && depth == 1);
}

static void mirror(double *matrix, int size, int first)
{
    for (int i = first; i < size; i++)
        for (int j = 0; j < i; j++)
            matrix[i * size + j] = matrix[j * size + i];
}

/* Gaussian elimination of `count` columns of (rows, pitch); a pivot of infinity skips a row. */
static void forward(double *work, int rows, int pitch, int count, double *pivots)
{
    for (int k = 0; k < count; k++)
        pivots[k] = TINY * work[k * pitch + k];
    for (int k = 0; k < count; k++) {
        const double *row = work + k * pitch;
        pivots[k] = row[k] > pivots[k] ? row[k] : INFINITY;
        for (int i = k + 1; i < rows; i++) {
            double *other = work + i * pitch;
            const double factor = other[k] / pivots[k];
            for (int j = k + 1; j < pitch; j++)
                other[j] -= factor * row[j];
        }
    }
}

/* Solutions (size, right) of matrix (size, size) for result (size, right), and overwrites it. */
static void solve(const double *matrix, int size, int right, double *result, double *work)
{
    const int pitch = size + right;
    double pivots[size];
    for (int i = 0; i < size; i++) {
        memcpy(work + i * pitch, matrix + i * size, size * sizeof(double));
        memcpy(work + i * pitch + size, result + i * right, right * sizeof(double));
    }
    forward(work, size, pitch, size, pivots);
    for (int i = 0; i < size; i++)
        memcpy(result + i * right, work + i * pitch + size, right * sizeof(double));
    for (int k = size - 1; k >= 0; k--)
        for (int m = 0; m < right; m++) {
            result[k * right + m] /= pivots[k];
            for (int i = 0; i < k; i++)
                result[i * right + m] -= work[i * pitch + k] * result[k * right + m];
        }
}

/* Hyperbolic tangent in place, as exact.tanh. */
static void tanh_of(const struct points *p, double *restrict values)
{
    const double magic = 1.5 * 4503599627370496.0;
    const double end = p->half / p->per_entry, step = 1 / p->per_entry;
    for (int k = 0; k < p->stride; k++) {
        double x = values[k] < -end ? -end : values[k];
        x = x > end ? end : x;
        const double entry = (x * p->per_entry + magic) - magic;
        const double d = x - entry * step, q = d * d;
        const double near = d + d * (q * (q * (q * (-17. / 315) + 2. / 15) + -1. / 3));
        const double there = p->table[p->half + (int32_t)entry];
        values[k] = (there + near) / (1 + there * near);
    }
}

/* Slices of the terms of the output layer. */
static void hidden_of(const struct points *p, const double *theta, double *hidden)
{
    const size_t slice = (size_t)terms_of(p) * p->stride;
    const double *x = p->fan, *y = p->fan + p->stride;
    for (int s = 0; s < p->slices; s++)
        memcpy(hidden + s * slice + p->neurons * p->stride,
               p->constant + (size_t)s * p->linear * p->stride,
               p->linear * p->stride * sizeof(double));
    for (int i = 0; i < p->neurons; i++, theta += 3) {
        double *restrict row = hidden + i * p->stride;
        for (int k = 0; k < p->stride; k++)
            row[k] = (theta[0] * x[k] + theta[1] * y[k] + theta[2]) * .5;
        tanh_of(p, row);
        memset(row + p->count, 0, (p->stride - p->count) * sizeof(double));
        double scale = 1;
        for (int s = 0; s + 1 < p->slices; s++, scale *= 1. / 4194304)
            for (int k = 0; k < p->stride; k++) {
                const double coarse = cut(row[s * slice + k], scale);
                row[(s + 1) * slice + k] = row[s * slice + k] - coarse;
                row[s * slice + k] = coarse;
            }
        for (int k = 0; k < p->stride; k++)
            row[(p->slices - 1) * slice + k] = cut(row[(p->slices - 1) * slice + k], scale);
    }
}

/* Targets minus the outputs of the network. */
static void residual_of(const struct points *p, const struct state *s, double *restrict sum)
{
    const int terms = terms_of(p);
    const size_t slice = (size_t)terms * p->stride;
    const double scale = scale_of(s->output, 2 * terms), fine = scale / 4194304;
    for (int axis = 0; axis < 2; axis++) {
        double *restrict rest = s->residual + axis * p->stride;
        memset(rest, 0, p->stride * sizeof(double));
        for (int pass = p->slices == 2 ? 0 : 1; pass < 3; pass++) {
            /* The products of slices in the order of exact.products, an exact sum each. */
            const double *terms_in = s->hidden + (pass == 0 ? slice : 0);
            memset(sum, 0, p->stride * sizeof(double));
            for (int i = 0; i < terms; i++) {
                const double whole = s->output[2 * i + axis], coarse = cut(whole, scale);
                const double weight = pass == 1 ? cut(whole - coarse, fine) : coarse;
                for (int k = 0; k < p->stride; k++)
                    sum[k] += weight * terms_in[i * p->stride + k];
            }
            for (int k = 0; k < p->stride; k++)
                rest[k] += sum[k];
        }
        for (int k = 0; k < p->stride; k++)
            rest[k] = p->targets[axis * p->stride + k] - rest[k];
    }
}

static void cut_residual(const struct points *p, const double *residual, double *result)
{
    const double scale = scale_of(residual, 2 * p->stride);
    for (int k = 0; k < 2 * p->stride; k++)
        result[k] = cut(residual[k], scale);
}

/* Output layer, residual and cost of the hidden neurons theta. */
static void evaluate(const struct points *p, const double *theta, struct state *s,
                     const struct work *w)
{
    const int terms = terms_of(p);
    double rest[2 * terms];
    hidden_of(p, theta, s->hidden);
    products(p, s->gram, terms, s->hidden, p->slices, terms, s->hidden, p->slices, terms);
    if (p->slices == 1)
        mirror(s->gram, terms, 0);
    for (int i = 0; i < p->neurons; i++)
        s->gram[i * terms + i] += p->ridge;
    products(p, s->output, 2, s->hidden, p->slices, terms, p->target_slices, p->slices, 2);
    solve(s->gram, terms, 2, s->output, w->matrix);
    residual_of(p, s, w->squares);
    /* One step of refinement: the normal equations square the condition number. */
    cut_residual(p, s->residual, w->residual);
    products(p, rest, 2, s->hidden, p->slices, terms, w->residual, 1, 2);
    for (int i = 0; i < 2 * p->neurons; i++)
        rest[i] -= p->ridge * s->output[i];
    solve(s->gram, terms, 2, rest, w->matrix);
    for (int i = 0; i < 2 * terms; i++)
        s->output[i] += rest[i];
    residual_of(p, s, w->squares);
    for (int axis = 0; axis < 2; axis++)
        for (int k = 0; k < p->count; k++) {
            const double value = s->residual[axis * p->stride + k];
            w->squares[axis * p->count + k] = value * value;
        }
    s->cost = total(w->squares, 2 * p->count);
    for (int i = 0; i < 2 * p->neurons; i++)
        w->squares[i] = s->output[i] * s->output[i];
    s->cost += p->ridge * total(w->squares, 2 * p->neurons);
}

/* Descent direction and normal matrix. */
static void gauss_newton(const struct points *p, const struct state *s, const struct work *w)
{
    const int terms = terms_of(p), size = 3 * p->neurons, whole = terms + size;
    double toward[2 * size], pivots[terms];
    for (int i = 0; i < p->neurons; i++) {
        double *restrict rows = w->derivative + 3 * i * p->stride;
        const double *hidden = s->hidden + i * p->stride;
        for (int k = 0; k < p->stride; k++) {
            const double slope = (1 - hidden[k] * hidden[k]) * .5;
            for (int axis = 0; axis < 3; axis++)
                rows[axis * p->stride + k] = cut(slope * p->fan[axis * p->stride + k], p->reach);
        }
    }
    cut_residual(p, s->residual, w->residual);
    products(p, toward, 2, w->derivative, 1, size, w->residual, 1, 2);
    for (int i = 0; i < size; i++) {
        const double *weight = s->output + 2 * (i / 3);
        w->gradient[i] = weight[0] * toward[2 * i] + weight[1] * toward[2 * i + 1];
    }
    /* Kaufman's approximation: derivatives minus their projection on the hidden outputs. */
    for (int i = 0; i < terms; i++)
        memcpy(w->joint + i * whole, s->gram + i * terms, terms * sizeof(double));
    products(p, w->joint + terms, whole, s->hidden, p->slices, terms, w->derivative, 1, size);
    products(p, w->joint + terms * whole + terms, whole, w->derivative, 1, size, w->derivative, 1,
             size);
    mirror(w->joint, whole, terms);
    forward(w->joint, whole, whole, terms, pivots);
    for (int i = 0; i < size; i++)
        for (int j = 0; j < size; j++) {
            const double *a = s->output + 2 * (i / 3), *b = s->output + 2 * (j / 3);
            w->normal[i * size + j] = w->joint[(terms + i) * whole + terms + j]
                                      * (a[0] * b[0] + a[1] * b[1]);
        }
}

/* A parameter at its bound whose gradient points outwards is fixed. */
static void hold(const struct points *p, const double *theta, const struct work *w)
{
    const int size = 3 * p->neurons;
    for (int i = 0; i < size; i++)
        if (fabs(theta[i]) >= p->limit[i % 3] && w->gradient[i] * theta[i] > 0) {
            for (int j = 0; j < size; j++)
                w->normal[i * size + j] = w->normal[j * size + i] = 0;
            w->normal[i * size + i] = 1;
            w->gradient[i] = 0;
        }
}

/* The trial parameters for a damping, and the fall of the cost that is expected of them. */
static double tried(const struct points *p, const double *theta, double damping,
                    const struct work *w)
{
    const int size = 3 * p->neurons;
    double damped[size * size], largest = w->normal[0], terms[size], rows[size];
    memcpy(damped, w->normal, sizeof damped);
    for (int i = 1; i < size; i++)
        largest = fmax(largest, w->normal[i * size + i]);
    for (int i = 0; i < size; i++)
        damped[i * size + i] += damping * (w->normal[i * size + i] + 1e-6 * largest + 1e-30);
    memcpy(w->move, w->gradient, size * sizeof(double));
    solve(damped, size, 1, w->move, w->matrix);
    for (int i = 0; i < size; i++) {
        const double limit = p->limit[i % 3], aim = theta[i] + w->move[i];
        w->trial[i] = aim < -limit ? -limit : aim > limit ? limit : aim;
        w->move[i] = w->trial[i] - theta[i];
    }
    for (int i = 0; i < size; i++) {
        for (int j = 0; j < size; j++)
            rows[j] = w->normal[i * size + j] * w->move[j];
        terms[i] = total(rows, size) * w->move[i];
    }
    const double square = total(terms, size);
    for (int i = 0; i < size; i++)
        terms[i] = w->move[i] * w->gradient[i];
    return 2 * total(terms, size) - square;
}

static void one_network(const struct points *p, int steps, double *theta, double *output,
                        double *damping, double *growth, double *costs, int pitch,
                        struct state s[2], const struct work *w)
{
    const size_t terms = terms_of(p);
    int moved = 1, stuck = 0;
    evaluate(p, theta, &s[0], w);
    costs[0] = s[0].cost;
    for (int step = 1; step <= steps; step++) {
        costs[step * pitch] = s[0].cost;
        if (stuck)
            continue;
        if (moved) {
            gauss_newton(p, &s[0], w);
            hold(p, theta, w);
        }
        const double expected = tried(p, theta, *damping, w);
        evaluate(p, w->trial, &s[1], w);
        const double gain = (s[0].cost - s[1].cost) / fmax(fabs(expected), 1e-300);
        moved = s[1].cost < s[0].cost;
        /* Once the damping and its growth are at their limits, a step that failed fails again. */
        stuck = !moved && *damping == MAX_DAMPING && *growth == MAX_GROWTH;
        /* Nielsen's rule: shrink by the quality of the quadratic model, grow progressively. */
        if (moved) {
            const double off = 2 * gain - 1, shrink = 1 - off * off * off;
            const struct state other = s[0];
            s[0] = s[1];
            s[1] = other;
            memcpy(theta, w->trial, 3 * p->neurons * sizeof(double));
            *damping *= shrink < .2 ? .2 : shrink > 2 ? 2 : shrink;
            *growth = 2;
        } else {
            *damping *= *growth;
            *growth = fmin(*growth * 2, MAX_GROWTH);
        }
        *damping = fmin(fmax(*damping, 1e-10), MAX_DAMPING);
        costs[step * pitch] = s[0].cost;
    }
    memcpy(output, s[0].output, 2 * terms * sizeof(double));
}

static double *taken(double **from, size_t count)
{
    double *begin = *from;
    *from += (count + 7) / 8 * 8;
    return begin;
}

/* `steps` iterations of each network: theta (networks, neurons, 3), output (networks, terms, 2),
 * damping and growth (networks); costs (steps + 1, networks) gets their costs, the first before
 * any step. Returns 0 if there is not enough memory.
 */
int search_steps(const struct points *p, int networks, int steps, double *theta, double *output,
                 double *damping, double *growth, double *costs)
{
    const size_t terms = terms_of(p), size = 3 * p->neurons, whole = terms + size;
    const size_t stride = p->stride;
    const size_t each = p->slices * terms * stride + terms * terms + 2 * terms + 2 * stride + 64;
    const size_t count = 2 * each + (size + 4) * stride + whole * whole + whole * (whole + 2)
                         + size * size + 3 * size + 128;
    double *memory = aligned_alloc(ALIGNED, (count * sizeof(double) + ALIGNED - 1)
                                   / ALIGNED * ALIGNED), *next = memory;
    struct state s[2];
    struct work w;
    if (!memory)
        return 0;
    for (int k = 0; k < 2; k++) {
        s[k].hidden = taken(&next, p->slices * terms * stride);
        s[k].gram = taken(&next, terms * terms);
        s[k].output = taken(&next, 2 * terms);
        s[k].residual = taken(&next, 2 * stride);
    }
    w.derivative = taken(&next, size * stride);
    w.residual = taken(&next, 2 * stride);
    w.squares = taken(&next, 2 * stride);
    w.joint = taken(&next, whole * whole);
    w.matrix = taken(&next, whole * (whole + 2));
    w.normal = taken(&next, size * size);
    w.gradient = taken(&next, size);
    w.move = taken(&next, size);
    w.trial = taken(&next, size);
    for (int n = 0; n < networks; n++)
        one_network(p, steps, theta + n * size, output + 2 * n * terms, damping + n, growth + n,
                    costs + n, networks, s, &w);
    free(memory);
    return 1;
}

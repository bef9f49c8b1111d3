/* Sums of products of rows that ncdc_model.exact has cut: exact in any order, fused or not. */
#pragma GCC optimize("fp-contract=fast")
#pragma clang fp contract(fast)

#ifdef __AVX512F__
#define LANES 8
#else
#define LANES 4
#endif
#define TALL 4                  /* rows of a tile: its sums stay in registers */
#define WIDE 2                  /* columns of it */
#define BLOCK 1024              /* terms of one exact sum, as in ncdc_model.exact */

typedef double vector __attribute__((vector_size(8 * LANES), aligned(8)));

static inline __attribute__((always_inline)) void tile(
    const int tall, const int wide, double *out, int pitch, const double *a, const double *b,
    int stride, int count)
{
    vector sum[TALL][WIDE] = {0};
    for (int k = 0; k < count; k += LANES)
        for (int i = 0; i < tall; i++)
            for (int j = 0; j < wide; j++)
                sum[i][j] += *(const vector *)(a + i * stride + k)
                             * *(const vector *)(b + j * stride + k);
    for (int i = 0; i < tall; i++)
        for (int j = 0; j < wide; j++) {
            double whole = 0;
            for (int lane = 0; lane < LANES; lane++)
                whole += sum[i][j][lane];
            out[i * pitch + j] += whole;
        }
}

/* Adds to out (rows, columns) the sums over the points of a (rows, stride) by b (columns, stride).
 *
 * Where `half` is set, cells below the diagonal may be left as they are. The stride is a multiple
 * of LANES.
 */
void add_products(double *out, int pitch, const double *a, int rows, const double *b, int columns,
                  int stride, int half)
{
    for (int start = 0; start < stride; start += BLOCK) {
        const int count = stride - start < BLOCK ? stride - start : BLOCK;
        for (int i = 0; i < rows;) {
            const int tall = rows - i < TALL ? 1 : TALL;
            for (int j = half ? i / WIDE * WIDE : 0; j < columns;) {
                const int wide = columns - j < WIDE ? 1 : WIDE;
                double *cell = out + i * pitch + j;
                const double *left = a + i * stride + start, *right = b + j * stride + start;
                if (tall == TALL && wide == WIDE)
                    tile(TALL, WIDE, cell, pitch, left, right, stride, count);
                else if (tall == TALL)
                    tile(TALL, 1, cell, pitch, left, right, stride, count);
                else if (wide == WIDE)
                    tile(1, WIDE, cell, pitch, left, right, stride, count);
                else
                    tile(1, 1, cell, pitch, left, right, stride, count);
                j += wide;
            }
            i += tall;
        }
    }
}

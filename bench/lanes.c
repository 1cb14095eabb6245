// SPDX-License-Identifier: Apache-2.0
/* The limit for bench/sweep.py: the closed loop `exact` in lanes, written by hand for this loop alone.
 *
 * Sets of (k, tau) of the controller, LANES side by side: the same arithmetic as the package (RK4,
 * linear hold, no contraction, no fast-math), events of w and y counted, the largest |y| and the
 * rms of y after settle, to the same bits: y is kept, and added up in numpy's order. Compile with cc -O3 -march=native -ffp-contract=off.
 */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>

#ifndef LANES
#define LANES 32 /* 1: the loop run one by one */
#endif
#define EACH for (int a = 0; a < LANES; a++)

typedef double Lane[LANES];

static const double K_W = 2.0, TAU_W = 1.0 / 12.0, K_P = 1.0, TAU_P = 1.0 / 11.0;

static inline void oscillator(const double x[4], double d, double k, double tau, double f[4])
{
    f[0] = x[0] - x[0] * x[0] * x[0] / 3.0 - x[1] + k * (d - x[2] - x[0]);
    f[1] = tau * (x[0] - x[1]);
    f[2] = x[2] - x[2] * x[2] * x[2] / 3.0 - x[3] + k * (-x[0] - x[2]);
    f[3] = tau * (x[2] - x[3]);
}

static inline void neuron(const double x[2], double d, double k, double tau, double f[2])
{
    f[0] = x[0] - x[0] * x[0] * x[0] / 3.0 - x[1] + k * (d - x[0]);
    f[1] = tau * (x[0] - x[1]);
}

#define STEP(name, rhs, D)                                                                         \
    static inline void name(double x[D], double d0, double dm, double d1, double k, double tau,    \
                            double h)                                                              \
    {                                                                                              \
        double k1[D], k2[D], k3[D], k4[D], z[D], half = 0.5 * h;                                   \
        rhs(x, d0, k, tau, k1);                                                                    \
        for (int i = 0; i < D; i++) z[i] = x[i] + half * k1[i];                                    \
        rhs(z, dm, k, tau, k2);                                                                    \
        for (int i = 0; i < D; i++) z[i] = x[i] + half * k2[i];                                    \
        rhs(z, dm, k, tau, k3);                                                                    \
        for (int i = 0; i < D; i++) z[i] = x[i] + h * k3[i];                                       \
        rhs(z, d1, k, tau, k4);                                                                    \
        for (int i = 0; i < D; i++)                                                                \
            x[i] = x[i] + h * ((k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]) / 6.0);                 \
    }

STEP(oscillator_step, oscillator, 4)
STEP(neuron_step, neuron, 2)

/* The time average of (y / big)^2 by trapezoids of equal length, as numpy sums them: in halves. */
static void halves(const Lane *square, const double *length, size_t n, Lane sum)
{
    if (n > 128) {
        size_t half = n / 2 - n / 2 % 8;
        Lane right;
        halves(square, length, half, sum);
        halves(square + half, length + half, n - half, right);
        EACH sum[a] += right[a];
        return;
    }
    Lane part[8];
    size_t i = 0;
#define TERM (0.5 * (square[i + 1][a] + square[i][a]) * length[i])
    if (n >= 8) {
        for (; i < 8; i++) EACH part[i][a] = TERM;
        for (; i < n - n % 8; i++) EACH part[i % 8][a] += TERM;
        EACH sum[a] = ((part[0][a] + part[1][a]) + (part[2][a] + part[3][a])) +
                      ((part[4][a] + part[5][a]) + (part[6][a] + part[7][a]));
    } else {
        EACH sum[a] = 0.0;
    }
    for (; i < n; i++) EACH sum[a] += TERM;
}

/* One block of lanes; verdict 1: rejected, 2: not rejected, 3: undecided. left: room for y. */
static void block(const double *k, const double *tau, size_t steps, double h, size_t begin,
                  const double *length, double total, Lane *left, int *verdict, double *largest,
                  double *rms)
{
    static _Thread_local Lane w[4], p[2], c[4], kc, tc, w1, y1, u1, big, wa, ya, nw, ny;
    EACH
    {
        w[0][a] = 1.0, w[1][a] = 0.0, w[2][a] = -1.0, w[3][a] = 0.0, p[0][a] = 0.0, p[1][a] = 0.0;
        c[0][a] = 0.5, c[1][a] = 0.0, c[2][a] = -0.5, c[3][a] = 0.0, kc[a] = k[a], tc[a] = tau[a];
        w1[a] = w[0][a], y1[a] = p[0][a], u1[a] = c[0][a];
        big[a] = nw[a] = ny[a] = 0.0, wa[a] = ya[a] = 1.0;
    }
    for (size_t n = 0; n < steps; n++) {
        EACH
        {
            double w0 = w[0][a], y0 = p[0][a], u0 = c[0][a];
            double sw = w0 - w1[a], sy = y0 - y1[a], su = u0 - u1[a];
            double x[4] = {w[0][a], w[1][a], w[2][a], w[3][a]};
            oscillator_step(x, 0.0, 0.0, 0.0, K_W, TAU_W, h);
            w[0][a] = x[0], w[1][a] = x[1], w[2][a] = x[2], w[3][a] = x[3];
            double q[2] = {y0, p[1][a]};
            neuron_step(q, w0 - u0, (w0 + 0.5 * sw) - (u0 + 0.5 * su), (w0 + sw) - (u0 + su), K_P,
                        TAU_P, h);
            p[0][a] = q[0], p[1][a] = q[1];
            double z[4] = {c[0][a], c[1][a], c[2][a], c[3][a]};
            oscillator_step(z, y0, y0 + 0.5 * sy, y0 + sy, kc[a], tc[a], h);
            c[0][a] = z[0], c[1][a] = z[1], c[2][a] = z[2], c[3][a] = z[3];
            w1[a] = w0, y1[a] = y0, u1[a] = u0;
        }
        double count = n + 1 >= begin ? 1.0 : 0.0;
        EACH
        {
            double x = w[0][a], y = p[0][a], rw = wa[a] * (x >= 1.0), ry = ya[a] * (y >= 1.0);
            nw[a] += count * rw, ny[a] += count * ry;
            wa[a] = x <= 0.0 ? 1.0 : wa[a] - rw, ya[a] = y <= 0.0 ? 1.0 : ya[a] - ry;
        }
        if (n + 1 >= begin)
            EACH
            {
                double y = p[0][a], size = fabs(y);
                left[n + 1 - begin][a] = y;
                big[a] = size > big[a] ? size : big[a];
            }
    }
    size_t samples = steps + 1 - begin;
    for (size_t i = 0; i < samples; i++)
        EACH
        {
            double part = left[i][a] / (big[a] != 0.0 ? big[a] : 1.0);
            left[i][a] = part * part;
        }
    Lane sum;
    halves((const Lane *)left, length, samples - 1, sum);
    EACH
    {
        verdict[a] = nw[a] < 3.0 ? 3 : ny[a] > 0.0 ? 2 : 1;
        largest[a] = big[a], rms[a] = big[a] * sqrt(sum[a] / total);
    }
}

/* begin is the first sample that counts, length holds the steps after it, total is their sum. */
int lanes(size_t sets, const double *k, const double *tau, size_t steps, double h, size_t begin,
          const double *length, double total, int *verdict, double *largest, double *rms)
{
    Lane *left = malloc((steps + 1 - begin) * sizeof(Lane));
    if (!left)
        return 1;
    for (size_t i = 0; i < sets; i += LANES)
        block(k + i, tau + i, steps, h, begin, length, total, left, verdict + i, largest + i,
              rms + i);
    free(left);
    return 0;
}

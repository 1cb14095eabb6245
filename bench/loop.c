// SPDX-License-Identifier: Apache-2.0
/* The limit: the closed loop of the scenario `exact`, written by hand.
 *
 * Classical RK4 with step h, every input held over the step (zero hold), the same equations as
 * eventreg_ros/models/neuron.py. Writes samples 0..steps of w, y and u. */
#include <stddef.h>

static const double K_W = 2.0, TAU_W = 1.0 / 12.0, K_P = 1.0, TAU_P = 1.0 / 11.0;

static void neuron(const double *x, double drive, double k, double tau, double *dx) {
  dx[0] = x[0] - x[0] * x[0] * x[0] / 3.0 - x[1] + k * (drive - x[0]);
  dx[1] = tau * (x[0] - x[1]);
}

static void oscillator(const double *x, double drive, double k, double tau, double *dx) {
  dx[0] = x[0] - x[0] * x[0] * x[0] / 3.0 - x[1] + k * (drive - x[2] - x[0]);
  dx[1] = tau * (x[0] - x[1]);
  dx[2] = x[2] - x[2] * x[2] * x[2] / 3.0 - x[3] + k * (-x[0] - x[2]);
  dx[3] = tau * (x[2] - x[3]);
}

#define RK4(NAME, RHS, DIM)                                                            \
  static void NAME(double *x, double drive, double k, double tau, double h) {          \
    double k1[DIM], k2[DIM], k3[DIM], k4[DIM], z[DIM];                                 \
    RHS(x, drive, k, tau, k1);                                                         \
    for (int i = 0; i < DIM; i++) z[i] = x[i] + 0.5 * h * k1[i];                       \
    RHS(z, drive, k, tau, k2);                                                         \
    for (int i = 0; i < DIM; i++) z[i] = x[i] + 0.5 * h * k2[i];                       \
    RHS(z, drive, k, tau, k3);                                                         \
    for (int i = 0; i < DIM; i++) z[i] = x[i] + h * k3[i];                             \
    RHS(z, drive, k, tau, k4);                                                         \
    for (int i = 0; i < DIM; i++)                                                      \
      x[i] += h * ((k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]) / 6.0);                 \
  }

RK4(step_neuron, neuron, 2)
RK4(step_oscillator, oscillator, 4)

void loop(size_t steps, double h, double *w, double *y, double *u) {
  double xw[4] = {1.0, 0.0, -1.0, 0.0}, xp[2] = {0.0, 0.0}, xc[4] = {0.5, 0.0, -0.5, 0.0};
  w[0] = xw[0], y[0] = xp[0], u[0] = xc[0];
  for (size_t n = 0; n < steps; n++) {
    step_oscillator(xw, 0.0, K_W, TAU_W, h);
    step_neuron(xp, w[n] - u[n], K_P, TAU_P, h);
    step_oscillator(xc, y[n], K_W, TAU_W, h);
    w[n + 1] = xw[0], y[n + 1] = xp[0], u[n + 1] = xc[0];
  }
}

// SPDX-License-Identifier: Apache-2.0
// The Poisson distribution in double precision: one text for the kernels of devices and for the processor
// (radiometry/stages/noise/poisson.cpp).

// (1 + d) log(1 + d) - d, which cancels where d is small.
FUNCTION double deviance(double d) {
  double sum = 0.0, power = d * d;
  int j;
  if (fabs(d) > 0.1) return (1.0 + d) * log1p(d) - d;
  for (j = 2; j < 20; ++j) {
    sum += power / (double)(j * (j - 1));
    power *= -d;
  }
  return sum;
}

// P(N = n) as a saddle point with the rest of Stirling's series (Loader, Fast and Accurate Computation of Binomial
// Probabilities, 2000), for small n as it is defined.
FUNCTION double probability(double n, double mean) {
  const double n2 = n * n;
  if (n < 16.0) {
    double p = exp(-mean);
    for (double k = 1.0; k <= n; k += 1.0) p *= mean / k;
    return p;
  }
  return exp(-mean * deviance((n - mean) / mean) -
             (1.0 / 12.0 - (1.0 / 360.0 - (1.0 / 1260.0 - 1.0 / (1680.0 * n2)) / n2) / n2) / n) /
         sqrt(2.0 * 3.14159265358979323846 * n);
}

// P(N <= n) for n <= mean, P(N > n) for n > mean: the smaller of the two tails, about. n >= 0.
FUNCTION double smaller_tail(double n, double mean) {
  double term = 1.0, sum = 0.0;
  if (n <= mean) {
    for (double k = n; term > 1e-17 * sum; k -= 1.0) {
      sum += term;
      if (k <= 0.0) break;
      term *= k / mean;
    }
    return probability(n, mean) * sum;
  }
  for (double k = n + 2.0; term > 1e-17 * sum; k += 1.0) {
    sum += term;
    term *= mean / k;
  }
  return probability(n + 1.0, mean) * sum;
}

// Whether P(N <= n) >= u, decided by the smaller tail. `rest` is 1 - u.
FUNCTION int reaches(double n, double mean, double u, double rest) {
  return n <= mean ? smaller_tail(n, mean) >= u : smaller_tail(n, mean) <= rest;
}

// A first guess to 5e-4 (Hastings, Approximations for Digital Computers, 1955), then Halley's iteration.
FUNCTION double quantile_of_normal(double u, double rest) {
  const double p = u < rest ? u : rest, t = sqrt(-2.0 * log(p));
  double z = t - (2.515517 + t * (0.802853 + t * 0.010328)) / (1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308)));
  for (int step = 0; step < 3; ++step) {
    const double tail = 0.5 * erfc(z * 1.41421356237309504880 * 0.5);
    const double newton = (tail - p) / (exp(-0.5 * z * z) / sqrt(2.0 * 3.14159265358979323846));
    z += newton / (1.0 - 0.5 * z * newton);
  }
  return u < rest ? -z : z;
}

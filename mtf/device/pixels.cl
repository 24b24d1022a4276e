
// ---- what a detector does to the pixels of an image (mtf/device/device_image.h), by the operations of the processor in
// their order, so that the numbers are the same to the bit ----
#ifndef HOST
#if defined(__OPENCL_VERSION__)
#define COUNT(p) atomic_inc(p)
#else
#define COUNT(p) atomicAdd(p, 1u)
#endif
typedef unsigned char u8;
typedef unsigned short u16;

// The third dimension of the grid counts the frames of a batch (DeviceImage::repeat).
#define PIXEL_OF(FRAME)                  \
  const int x = GX, y = GY;              \
  if (x >= columns || y >= rows) return; \
  const u64 at = ((u64)(FRAME) * (u64)rows + (u64)y) * (u64)columns + (u64)x
#define PIXEL PIXEL_OF(GZ)

KERNEL void repeat(GLOBAL float* frames, int columns, int rows, GLOBAL const float* image) {
  PIXEL;
  frames[at] = image[(u64)y * (u64)columns + (u64)x];
}

// image = (g gains + g0) image + (o offsets + o0); 1 in place of a map that is not there.
KERNEL void multiply_add(GLOBAL float* image, int columns, int rows, GLOBAL const float* gains, int has_gains, float g,
                         float g0, GLOBAL const float* offsets, int has_offsets, float o, float o0) {
  PIXEL;
  const u64 of_map = (u64)y * (u64)columns + (u64)x;
  const float gain = has_gains ? gains[of_map] : 1.0f, offset = has_offsets ? offsets[of_map] : 1.0f;
  image[at] = (g * gain + g0) * image[at] + (o * offset + o0);
}

KERNEL void add_map(GLOBAL float* image, int columns, int rows, GLOBAL const float* map) {
  PIXEL;
  image[at] += map[(u64)y * (u64)columns + (u64)x];
}

// A number for each row, or for each column; those of the next frame come `stride` later.
KERNEL void add_lines(GLOBAL float* image, int columns, int rows, GLOBAL const float* numbers, int of_rows, int stride) {
  PIXEL;
  image[at] += numbers[stride * GZ + (of_rows ? y : x)];
}

KERNEL void clear(GLOBAL u32* counts, int count) {
  if (GX < count) counts[GX] = 0u;
}

// Finite pixels by 16 bits, from `shift` on, of a key that rises with their value; shift 0: of those alone whose upper
// half is `upper`.
KERNEL void count_keys(GLOBAL const float* image, int columns, int rows, GLOBAL u32* counts, int frame, int shift,
                       u32 upper) {
  PIXEL_OF(frame);
  const u32 bits = (u32)BITS_OF(image[at]), key = (bits & 0x80000000u) != 0 ? ~bits : bits | 0x80000000u;
  if ((bits & 0x7f800000u) == 0x7f800000u || (shift == 0 && key >> 16 != upper)) return;
  COUNT(&counts[(key >> shift) & 0xffffu]);
}

#ifdef DOUBLES
// The gain (radiometry/stages/processing/agc.cpp): pixels by their bin, and a curve of so many straight intervals.
KERNEL void count_bins(GLOBAL const float* image, int columns, int rows, GLOBAL u32* counts, int frame, double low,
                       double scale, int bins) {
  PIXEL_OF(frame);
  const double place = ((double)image[at] - low) * scale;
  if (!(place >= 0.0 && place <= (double)bins)) return;
  const int bin = (int)place;
  COUNT(&counts[bin < bins - 1 ? bin : bins - 1]);
}

KERNEL void tone(GLOBAL float* image, int columns, int rows, GLOBAL const float* levels, int frame, int intervals,
                 double low, double scale) {
  PIXEL_OF(frame);
  const float value = image[at];
  const double place = ((double)value - low) * scale, most = (double)intervals;
  const double inside = !(place > 0.0) ? 0.0 : place < most ? place : most;
  const int interval = (int)inside < intervals ? (int)inside : intervals - 1;
  const float share = (float)(inside - (double)interval);
  if (value == value) image[at] = levels[interval] * (1.0f - share) + levels[interval + 1] * share;
}

// The nearest whole numbers of what is not negative; not-a-number has none, and is counted.
#define WHOLE_NUMBERS(NAME, T)                                                                            \
  KERNEL void NAME(GLOBAL const float* image, int columns, int rows, GLOBAL T* whole, GLOBAL u32* counts) { \
    PIXEL;                                                                                                \
    const float value = image[at];                                                                        \
    if (value != value) COUNT(&counts[4 * GZ + 3]);                                                                \
    whole[at] = value == value ? (T)floor((double)value + 0.5) : (T)0;                                    \
  }
WHOLE_NUMBERS(whole_bytes, u8)
WHOLE_NUMBERS(whole_words, u16)

// A thread for the two pixels that share a block of random words (radiometry/stages/noise/random.h): those of columns
// 2 half and 2 half + 1 of the detector, at x and x + 1 of the image.
#define PAIR                                               \
  const int y = GY, x = 2 * GX - (int)(x0 & 1u);             \
  if (x >= columns || y >= rows) return;                   \
  const u64 at = ((u64)GZ * (u64)rows + (u64)y) * (u64)columns; \
  const Block w = philox(x0 / 2u + (u32)GX, y0 + (u32)y, frame + (u32)GZ * step, stream, k0, k1)

// radiometry/stages/noise/noise_lanes.cpp
KERNEL void add_gaussian(GLOBAL float* image, int columns, int rows, float sigma, u32 x0, u32 y0, u32 frame, u32 step,
                         u32 stream, u32 k0, u32 k1) {
  PAIR;
  const int a = (int)(w.x >> 1), b = (int)(w.y >> 1);
  const float radius = root_of(2.0f * minus_log(unit_interval(a, b), unit_interval(0x7fffffff - a, 0x7fffffff - b)));
  const Number t = turned(w.z);
  if (x >= 0) image[at + (u64)x] += sigma * (radius * t.re);
  if (x + 1 < columns) image[at + (u64)(x + 1)] += sigma * (radius * t.im);
}

// Poisson numbers by inversion (radiometry/stages/noise/poisson.h): decided in single precision where that is enough,
// else in double, else by the distribution function.
#define POISSON_SHIFT(T, NAME)                                                                                   \
  FUNCTION T NAME(T root, T r, T w) {                                                                            \
    const T w2 = w * w;                                                                                          \
    const T c2 = (T)(1.0 / 3.0) + w2 * (T)(1.0 / 6.0);                                                           \
    const T c3 = -w * ((T)(1.0 / 36.0) + w2 * (T)(1.0 / 72.0));                                                  \
    const T c4 = (T)(-8.0 / 405.0) + w2 * ((T)(7.0 / 810.0) + w2 * (T)(1.0 / 270.0));                            \
    const T c5 = w * ((T)(671.0 / 38880.0) + w2 * ((T)(-137.0 / 38880.0) - w2 * (T)(23.0 / 17280.0)));           \
    const T c6 = (T)(-16.0 / 25515.0) +                                                                          \
                 w2 * ((T)(-5189.0 / 408240.0) + w2 * ((T)(5.0 / 3024.0) + w2 * (T)(19.0 / 34020.0)));           \
    return root * w + (c2 + r * (c3 + r * (c4 + r * (c5 + r * c6))));                                            \
  }
POISSON_SHIFT(float, shift_single)
POISSON_SHIFT(double, shift_double)

// sqrt(2) erfinv(v) / v with t = -log(1 - v^2), t in [0, 9].
FUNCTION float single_quantile(float t) {
  const float c[12] = {SINGLE_QUANTILE};
  const float s = t * (1.0f / 4.5f) - 1.0f;
  float p = c[0];
  for (int k = 1; k < 12; ++k) p = p * s + c[k];
  return p;
}

FUNCTION double double_quantile(double t) {
  const double c[21] = {DOUBLE_QUANTILE};
  const double s = t * (1.0 / 4.5) - 1.0;
  double p = c[0];
  for (int k = 1; k < 21; ++k) p = p * s + c[k];
  return p;
}

FUNCTION double poisson_double(int a, int b, double mean) {
  const double u = ((double)a + ((double)b + 0.5) * 0x1p-31) * 0x1p-31;
  const double rest = ((double)(0x7fffffff - a) + ((double)(0x7fffffff - b) + 0.5) * 0x1p-31) * 0x1p-31;
  double n = 0.0;
  if (isnan(mean)) return mean;
  if (!(mean > 0.0)) return 0.0;
  if (isinf(mean)) return mean;
  if (mean >= 32.0) {
    const double root = sqrt(mean), t = -log(4.0 * u * rest);
    const double w = t <= 9.0 ? (u - rest) * double_quantile(t) : quantile_of_normal(u, rest);
    const double guess = mean + shift_double(root, 1.0 / root, w), part = guess - floor(guess);
    const double w4 = w * w * w * w;
    const double error = mean >= 1e8 ? 0.0
                                     : 12.0 / (mean * mean * root) + 1e-11 * root + 4e-16 * mean +
                                           (t <= 9.0 ? 0.0 : 1e-3 * w4 * w4 / (mean * mean * root));
    n = floor(guess) > 0.0 ? floor(guess) : 0.0;
    if (mean >= 1e8 || ((t <= 9.0 || mean >= 1e4) && part > error && part < 1.0 - error)) return n;
  } else {
    double term = exp(-mean), sum = term;
    for (n = 0.0; n < 256.0; n += 1.0) {
      const double ahead = u - sum;
      if (fabs(ahead) < 1e-12) break;
      if (ahead < 0.0) return n;
      term *= mean / (n + 1.0);
      sum += term;
    }
  }
  while (!reaches(n, mean, u, rest)) n += 1.0;
  while (n > 0.0 && reaches(n - 1.0, mean, u, rest)) n -= 1.0;
  return n;
}

FUNCTION float poisson(u32 high, u32 low, float mean) {
  const int a = (int)(high >> 1), b = (int)(low >> 1);
  if (mean >= 32.0f && mean < 0x1p22f) {
    const float root = root_of(mean), r = (float)(1.0 / (double)root);
    const float s = ((float)(a - 0x40000000) + 0.5f) * 0x1p-30f;
    const float t = minus_log(4.0f * (unit_interval(a, b) * unit_interval(0x7fffffff - a, 0x7fffffff - b)), s * s);
    const float w = s * single_quantile(t), whole = floor(mean);
    const float guess = (mean - whole) + shift_single(root, r, w), n = floor(guess), part = guess - n;
    const float error = 1.5e-6f * fabs(root * w) + 4e-6f + 12.0f * (r * r) * (r * r) * r;
    if (part > error && part < 1.0f - error && t < 0.99f * 9.0f) return whole + n;
  }
  return (float)poisson_double(a, b, (double)mean);
}

KERNEL void shot_noise(GLOBAL float* image, int columns, int rows, u32 x0, u32 y0, u32 frame, u32 step, u32 stream,
                       u32 k0, u32 k1) {
  PAIR;
  if (x >= 0) image[at + (u64)x] = poisson(w.x, w.y, image[at + (u64)x]);
  if (x + 1 < columns) image[at + (u64)(x + 1)] = poisson(w.z, w.w, image[at + (u64)(x + 1)]);
}

// radiometry/stages/detector: the full well; a response that is not straight; the converter. Pixels that are held at an
// end are counted, of each frame: at the well, at the least and at the largest count, and those that are no numbers.
KERNEL void hold_well(GLOBAL float* image, int columns, int rows, GLOBAL u32* counts, float well) {
  PIXEL;
  if (image[at] > well) {
    image[at] = well;
    COUNT(&counts[4 * GZ]);
  }
}

KERNEL void bend(GLOBAL float* image, int columns, int rows, double well, double a2, double a3, double a4) {
  PIXEL;
  const double e = (double)image[at], u = e / well;
  double bent = e;
  if (u > 1.0)
    bent = well * (1.0 + a2 + a3 + a4) + (e - well) * (1.0 + 2.0 * a2 + 3.0 * a3 + 4.0 * a4);
  else if (u > 0.0)
    bent = e * (1.0 + u * (a2 + u * (a3 + u * a4)));
  image[at] = (float)bent;
}

KERNEL void digitise(GLOBAL float* image, int columns, int rows, GLOBAL u32* counts, double scale, double offset,
                     double most) {
  PIXEL;
  const double count = floor((double)image[at] * scale + offset);
  if (count < 0.0) COUNT(&counts[4 * GZ + 1]);
  if (count > most) COUNT(&counts[4 * GZ + 2]);
  const double held = count < 0.0 ? 0.0 : count;
  image[at] = (float)(held > most ? most : held);
}
#endif
#endif

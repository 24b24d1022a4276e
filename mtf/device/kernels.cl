// SPDX-License-Identifier: Apache-2.0
// One text, three readers: OpenCL C 1.2, CUDA C (NVRTC), and C++ on the host for the functions alone. Numbers that have to
// be the same to the bit on all are made of + - * and fused sums that are written out; contraction is off.

#if defined(__OPENCL_VERSION__)
#pragma OPENCL FP_CONTRACT OFF
#define KERNEL __kernel
#define GLOBAL __global
#define FUNCTION static inline
typedef uint u32;
typedef ulong u64;
#ifdef cl_khr_fp64
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#define DOUBLES
#endif
#define GX ((int)get_global_id(0))
#define GY ((int)get_global_id(1))
#define GZ ((int)get_global_id(2))
#define FUSED(a, b, c) fma((float)(a), (float)(b), (float)(c))
#define BITS_OF(x) as_int((float)(x))
#define FLOAT_OF(x) as_float((int)(x))
#elif defined(__CUDACC_RTC__)
#define KERNEL extern "C" __global__
#define GLOBAL
#define FUNCTION static __device__ __forceinline__
typedef unsigned int u32;
typedef unsigned long long u64;
#define DOUBLES
#define GX ((int)(blockIdx.x * blockDim.x + threadIdx.x))
#define GY ((int)(blockIdx.y * blockDim.y + threadIdx.y))
#define GZ ((int)(blockIdx.z * blockDim.z + threadIdx.z))
#define FUSED(a, b, c) fmaf(a, b, c)
#define BITS_OF(x) __float_as_int(x)
#define FLOAT_OF(x) __int_as_float(x)
#else
#define HOST 1
#define DOUBLES
#define GLOBAL
#define FUNCTION inline
typedef std::uint32_t u32;
typedef std::uint64_t u64;
#define FUSED(a, b, c) std::fmaf(a, b, c)
#define BITS_OF(x) std::bit_cast<std::int32_t>(x)
#define FLOAT_OF(x) std::bit_cast<float>(x)
#endif

// ---- Philox4x32-10 (Salmon, Moraes, Dror and Shaw, SC11, 2011), as radiometry/stages/noise/random.h has it ----
typedef struct {
  u32 x, y, z, w;
} Block;

FUNCTION Block philox(u32 c0, u32 c1, u32 c2, u32 c3, u32 k0, u32 k1) {
  Block r;
  for (int i = 0; i < 10; ++i) {
    const u64 p0 = (u64)0xD2511F53u * c0, p1 = (u64)0xCD9E8D57u * c2;
    const u32 n0 = (u32)(p1 >> 32) ^ c1 ^ k0, n2 = (u32)(p0 >> 32) ^ c3 ^ k1;
    c1 = (u32)p1;
    c3 = (u32)p0;
    c0 = n0;
    c2 = n2;
    k0 += 0x9E3779B9u;
    k1 += 0xBB67AE85u;
  }
  r.x = c0;
  r.y = c1;
  r.z = c2;
  r.w = c3;
  return r;
}

// (a + (b + 1/2) 2^-31) 2^-31, a and b of 31 bits.
FUNCTION float unit_interval(int a, int b) {
  return ((float)a + ((float)b + 0.5f) * 0x1p-31f) * 0x1p-31f;
}

// -log(u); `rest` = 1 - u, used next to u = 1. log(1 + f) / f is a polynomial of least deviation, 5e-9.
FUNCTION float minus_log(float u, float rest) {
  const int bits = BITS_OF(u), e = (bits - 0x3f3504f3) >> 23;
  const float m = FLOAT_OF(bits - e * (1 << 23));
  const float f = e == 0 ? -rest : m - 1.0f;
  float p = -0.07451196828f;
  p = p * f + 0.1280662843f;
  p = p * f - 0.1326603638f;
  p = p * f + 0.1419964791f;
  p = p * f - 0.1660836859f;
  p = p * f + 0.2000093951f;
  p = p * f - 0.2500157913f;
  p = p * f + 0.3333334535f;
  p = p * f - 0.499999885f;
  p = p * f + 1.0f;
  return -((float)e * 0.69314718056f + f * p);
}

// A complex number.
typedef struct {
  float re, im;
} Number;

// exp(2 pi i word / 2^32).
FUNCTION Number turned(u32 word) {
  Number r;
  const u32 quarter = (word + 0x20000000u) >> 30;
  const int rest = (int)(word - (quarter << 30));
  const float x = ((float)rest + 0.5f) * 0x1p-30f, y = x * x;
  float s = 0.0001582063036f, c = 0.0009036280664f;
  s = s * y - 0.004681266257f;
  s = s * y + 0.07969258273f;
  s = s * y - 0.6459640961f;
  s = (s * y + 1.570796327f) * x;
  c = c * y - 0.0208600695f;
  c = c * y + 0.2536692037f;
  c = c * y - 1.233700541f;
  c = c * y + 1.0f;
  r.re = (quarter & 1u) != 0 ? s : c;
  r.im = (quarter & 1u) != 0 ? c : s;
  if (((quarter + 1u) & 2u) != 0) r.re = -r.re;
  if ((quarter & 2u) != 0) r.im = -r.im;
  return r;
}

#ifdef DOUBLES
// Rounded once, as one in single precision would not be on every device.
FUNCTION float root_of(float x) { return (float)sqrt((double)x); }
#endif

// The numbers that have to be the same on every device.
FUNCTION void bits_of_input(GLOBAL u32* out, int i) {
  const Block w = philox((u32)i, 17u, 3u, 2u, 0x12345678u, 0x9abcdef0u);
  const Number t = turned(w.z);
  const int a = (int)(w.x >> 1), b = (int)(w.y >> 1);
  const float u = unit_interval(a, b);
  out[0] = w.x;
  out[1] = w.y;
  out[2] = w.z;
  out[3] = w.w;
  out[4] = (u32)BITS_OF(minus_log(u, unit_interval(0x7fffffff - a, 0x7fffffff - b)));
  out[5] = (u32)BITS_OF(t.re);
  out[6] = (u32)BITS_OF(t.im);
  out[7] = (u32)BITS_OF(FUSED(u, t.re, t.im));
#ifdef DOUBLES
  out[8] = (u32)BITS_OF(root_of(u));
  out[9] = (u32)BITS_OF((float)(((double)u * (double)t.re + (double)t.im) * 0x1p30));
#endif
}

#ifndef HOST
KERNEL void bits(GLOBAL u32* out, int inputs) {
  if (GX < inputs) bits_of_input(out + (u64)GX * 10, GX);
}

// ---- the filter (mtf/device/device_filter.h) ----

// from_x, from_y: the sample at each place of the canvas, -1 for that of a constant border.
KERNEL void gather(GLOBAL float* canvas, GLOBAL const float* scene, GLOBAL const int* from_x, GLOBAL const int* from_y,
                   int columns, int rows, int stride, int scene_columns, float mean, float scale, float border) {
  const int x = GX, y = GY;
  if (x >= columns || y >= rows) return;
  const int sx = from_x[x], sy = from_y[y];
  float value = border;
  if (sx >= 0 && sy >= 0) value = (scene[(u64)sy * (u64)scene_columns + (u64)sx] - mean) * scale;
  canvas[(u64)y * (u64)stride + (u64)x] = value;
}

// A frequency of an axis and the factor of its phase: along x its signed number; along y the rows of spectrum and OTF
// that hold it and those of its negative.
typedef struct {
  int k;
  float re, im;
} TermX;
typedef struct {
  int source, otf, mirror_source, mirror_otf;
  float re, im;
} TermY;

FUNCTION Number times(Number a, Number b) {
  Number r;
  r.re = a.re * b.re - a.im * b.im;
  r.im = a.re * b.im + a.im * b.re;
  return r;
}

// The terms of detector frequency X are x[first_x[X]] .. x[first_x[X + 1] - 1]. Frequencies k < 0 are the conjugates of
// -k, both of the spectrum and of the OTF.
KERNEL void fold(GLOBAL Number* out, GLOBAL const Number* spectrum, GLOBAL const float* otf, GLOBAL const int* first_x,
                 GLOBAL const TermX* terms_x, GLOBAL const int* first_y, GLOBAL const TermY* terms_y, int out_columns,
                 int out_rows, int columns, int otf_columns, int is_complex) {
  const int x = GX, y = GY;
  if (x >= out_columns || y >= out_rows) return;
  Number sum;
  sum.re = 0.0f;
  sum.im = 0.0f;
  for (int i = first_x[x]; i < first_x[x + 1]; ++i) {
    const TermX a = terms_x[i];
    const int mirrored = a.k < 0, k = mirrored ? -a.k : a.k;
    Number phase_x;
    phase_x.re = a.re;
    phase_x.im = a.im;
    for (int j = first_y[y]; j < first_y[y + 1]; ++j) {
      const TermY b = terms_y[j];
      Number v = spectrum[(u64)(mirrored ? b.mirror_source : b.source) * (u64)columns + (u64)k], phase_y;
      const u64 h = (u64)(mirrored ? b.mirror_otf : b.otf) * (u64)otf_columns + (u64)k;
      if (is_complex) {
        Number f;
        f.re = otf[2 * h];
        f.im = otf[2 * h + 1];
        v = times(v, f);
      } else {
        v.re *= otf[h];
        v.im *= otf[h];
      }
      if (mirrored) v.im = -v.im;
      phase_y.re = b.re;
      phase_y.im = b.im;
      v = times(times(v, phase_y), phase_x);
      sum.re += v.re;
      sum.im += v.im;
    }
  }
  out[(u64)y * (u64)out_columns + (u64)x] = sum;
}

// What `mean` has beyond float is added first.
KERNEL void scatter(GLOBAL float* image, GLOBAL const float* canvas, int columns, int rows, int stride, float unscale,
                    float mean, float beyond) {
  const int x = GX, y = GY;
  if (x >= columns || y >= rows) return;
  image[(u64)y * (u64)columns + (u64)x] = (canvas[(u64)y * (u64)stride + (u64)x] * unscale + beyond) + mean;
}

// A direct kernel (mtf/device/device_taps.h); those taps of row r count from spans[2 r] to spans[2 r + 1] - 1.
KERNEL void weigh(GLOBAL float* image, GLOBAL const float* canvas, GLOBAL const float* taps, GLOBAL const int* spans,
                  int columns, int rows, int stride, int ratio_x, int ratio_y, int tap_columns, int tap_rows,
                  float unscale, float mean, float beyond) {
  const int x = GX, y = GY;
  float sum = 0.0f;
  if (x >= columns || y >= rows) return;
  for (int r = 0; r < tap_rows; ++r) {
    GLOBAL const float* const from = canvas + ((u64)(y * ratio_y + r) * (u64)stride + (u64)(x * ratio_x));
    GLOBAL const float* const row = taps + r * tap_columns;
    for (int t = spans[2 * r]; t < spans[2 * r + 1]; ++t) sum += row[t] * from[t];
  }
  image[(u64)y * (u64)columns + (u64)x] = (sum * unscale + beyond) + mean;
}
#endif

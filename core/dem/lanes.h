// Vectors of doubles for the kernels: one set of names over AVX2 (4 lanes) and AVX-512 (8 lanes).
//
// Every operation here is correctly rounded lane by lane, so a kernel written with it computes the same bits
// as its plain scalar twin. Included only by the kernel sources compiled for one instruction set; all names
// live in that set's namespace, so that no wide instruction can leak into the rest of the program.
#pragma once

#include <immintrin.h>

#include <cstdint>

#include "core/dem/kernels.h"

namespace creep::CREEP_KERNEL_NAMESPACE {

#if defined(__AVX512F__)

inline constexpr int kLanes = 8;
using Mask = __mmask8;

struct Vec {
  __m512d v;
};
struct Int {
  __m512i v;
};

inline Vec all(double x) { return {_mm512_set1_pd(x)}; }
inline Int all_int(std::int64_t x) { return {_mm512_set1_epi64(x)}; }
inline Vec load(const double* p) { return {_mm512_load_pd(p)}; }
inline Vec load_anywhere(const double* p) { return {_mm512_loadu_pd(p)}; }
inline void store(double* p, Vec a) { _mm512_store_pd(p, a.v); }
inline void store_anywhere(double* p, Vec a) { _mm512_storeu_pd(p, a.v); }
inline Vec operator+(Vec a, Vec b) { return {_mm512_add_pd(a.v, b.v)}; }
inline Vec operator-(Vec a, Vec b) { return {_mm512_sub_pd(a.v, b.v)}; }
inline Vec operator*(Vec a, Vec b) { return {_mm512_mul_pd(a.v, b.v)}; }
inline Vec operator/(Vec a, Vec b) { return {_mm512_div_pd(a.v, b.v)}; }
inline Vec fma(Vec a, Vec b, Vec c) { return {_mm512_fmadd_pd(a.v, b.v, c.v)}; }
inline Vec sqrt(Vec a) { return {_mm512_sqrt_pd(a.v)}; }
inline Vec max(Vec a, Vec b) { return {_mm512_max_pd(a.v, b.v)}; }
inline Vec min(Vec a, Vec b) { return {_mm512_min_pd(a.v, b.v)}; }
inline Mask greater(Vec a, Vec b) { return _mm512_cmp_pd_mask(a.v, b.v, _CMP_GT_OQ); }
inline Mask both(Mask a, Mask b) { return static_cast<Mask>(a & b); }
inline bool any(Mask m) { return m != 0; }
inline int count(Mask m) { return __builtin_popcount(m); }
inline Mask first_lanes(int n) { return static_cast<Mask>((1u << n) - 1u); }
inline Vec select(Mask m, Vec yes, Vec no) { return {_mm512_mask_blend_pd(m, no.v, yes.v)}; }
inline Vec keep(Mask m, Vec a) { return {_mm512_maskz_mov_pd(m, a.v)}; }
/// Both are false for what is no number.
inline Mask differ(Vec a, Vec b) { return _mm512_cmp_pd_mask(a.v, b.v, _CMP_NEQ_OQ); }
inline Mask equal(Vec a, Vec b) { return _mm512_cmp_pd_mask(a.v, b.v, _CMP_EQ_OQ); }
inline Int bits(Vec a) { return {_mm512_castpd_si512(a.v)}; }
inline Vec from_bits(Int a) { return {_mm512_castsi512_pd(a.v)}; }
inline Int operator+(Int a, Int b) { return {_mm512_add_epi64(a.v, b.v)}; }
inline Int operator-(Int a, Int b) { return {_mm512_sub_epi64(a.v, b.v)}; }
inline Int operator&(Int a, Int b) { return {_mm512_and_si512(a.v, b.v)}; }
inline Int operator|(Int a, Int b) { return {_mm512_or_si512(a.v, b.v)}; }
inline Int shift_right(Int a, int n) { return {_mm512_srl_epi64(a.v, _mm_cvtsi32_si128(n))}; }
inline std::int64_t sum(Int a) { return _mm512_reduce_add_epi64(a.v); }
inline void store(std::int64_t* p, Int a) { _mm512_storeu_si512(p, a.v); }

/// Rows r[0..7] of eight doubles each become columns.
inline void transpose(const __m512d r[8], Vec out[8]) {
  const __m512d a0 = _mm512_unpacklo_pd(r[0], r[1]), a1 = _mm512_unpackhi_pd(r[0], r[1]);
  const __m512d a2 = _mm512_unpacklo_pd(r[2], r[3]), a3 = _mm512_unpackhi_pd(r[2], r[3]);
  const __m512d a4 = _mm512_unpacklo_pd(r[4], r[5]), a5 = _mm512_unpackhi_pd(r[4], r[5]);
  const __m512d a6 = _mm512_unpacklo_pd(r[6], r[7]), a7 = _mm512_unpackhi_pd(r[6], r[7]);
  // a0 holds elements 0,2,4,6 of rows 0 and 1 in its four 128-bit blocks, and so on.
  const __m512d b0 = _mm512_shuffle_f64x2(a0, a2, 0x88), b1 = _mm512_shuffle_f64x2(a0, a2, 0xdd);
  const __m512d b2 = _mm512_shuffle_f64x2(a4, a6, 0x88), b3 = _mm512_shuffle_f64x2(a4, a6, 0xdd);
  const __m512d b4 = _mm512_shuffle_f64x2(a1, a3, 0x88), b5 = _mm512_shuffle_f64x2(a1, a3, 0xdd);
  const __m512d b6 = _mm512_shuffle_f64x2(a5, a7, 0x88), b7 = _mm512_shuffle_f64x2(a5, a7, 0xdd);
  out[0].v = _mm512_shuffle_f64x2(b0, b2, 0x88);
  out[4].v = _mm512_shuffle_f64x2(b0, b2, 0xdd);
  out[2].v = _mm512_shuffle_f64x2(b1, b3, 0x88);
  out[6].v = _mm512_shuffle_f64x2(b1, b3, 0xdd);
  out[1].v = _mm512_shuffle_f64x2(b4, b6, 0x88);
  out[5].v = _mm512_shuffle_f64x2(b4, b6, 0xdd);
  out[3].v = _mm512_shuffle_f64x2(b5, b7, 0x88);
  out[7].v = _mm512_shuffle_f64x2(b5, b7, 0xdd);
}

/// Fields x, y, z, radius, vx, vy, vz, breaking_stress of eight bodies.
inline void load_bodies(const Body* body, const std::int32_t* index, Vec out[8]) {
  __m512d rows[8];
  for (int k = 0; k < 8; ++k) rows[k] = _mm512_load_pd(&body[index[k]].x);
  transpose(rows, out);
}

inline Vec load_radii(const Body* body, const std::int32_t* index) {
  const __m256i place = _mm256_slli_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(index)), 3);
  return {_mm512_i32gather_pd(place, &body->radius, sizeof(double))};
}

/// Of eight pairs of bodies: second minus first of x, y, z and vx, vy, vz; the sum of the radii; the smaller
/// breaking stress.
inline void load_pairs(const Body* body, const std::int32_t* first, const std::int32_t* second, Vec out[8]) {
  __m512d rows[8];
  for (int k = 0; k < 8; ++k) {
    const __m512d a = _mm512_load_pd(&body[first[k]].x), b = _mm512_load_pd(&body[second[k]].x);
    rows[k] = _mm512_mask_min_pd(_mm512_mask_add_pd(_mm512_sub_pd(b, a), 0x08, a, b), 0x80, a, b);
  }
  transpose(rows, out);
}

inline Int load_indices(const std::int32_t* p) {
  return {_mm512_cvtepi32_epi64(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(p)))};
}

/// Four doubles at p + 4 at[k] for each lane k, as four vectors.
inline void load_quads_at(const double* p, const std::int64_t at[8], Vec out[4]) {
  __m512d pair[4];
  for (int k = 0; k < 4; ++k) {  // lanes k and k+4 side by side
    pair[k] = _mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_load_pd(p + 4 * at[k])),
                                 _mm256_load_pd(p + 4 * at[k + 4]), 1);
  }
  const __m512d a = _mm512_unpacklo_pd(pair[0], pair[1]), b = _mm512_unpackhi_pd(pair[0], pair[1]);
  const __m512d c = _mm512_unpacklo_pd(pair[2], pair[3]), d = _mm512_unpackhi_pd(pair[2], pair[3]);
  const __m512i low = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
  const __m512i high = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
  out[0].v = _mm512_permutex2var_pd(a, low, c);
  out[1].v = _mm512_permutex2var_pd(b, low, d);
  out[2].v = _mm512_permutex2var_pd(a, high, c);
  out[3].v = _mm512_permutex2var_pd(b, high, d);
}

inline void load_quads(const double* p, Int index, Vec out[4]) {
  alignas(64) std::int64_t at[8];
  _mm512_store_si512(at, index.v);
  load_quads_at(p, at, out);
}

inline void load_consecutive_quads(const double* p, Vec out[4]) {
  static constexpr std::int64_t kAt[8] = {0, 1, 2, 3, 4, 5, 6, 7};
  load_quads_at(p, kAt, out);
}

inline void load_consecutive_bodies(const Body* body, Vec out[8]) {
  __m512d rows[8];
  for (int k = 0; k < 8; ++k) rows[k] = _mm512_load_pd(&body[k].x);
  transpose(rows, out);
}

inline void store_consecutive_bodies(Body* body, const Vec fields[8]) {
  __m512d columns[8];
  Vec rows[8];
  for (int k = 0; k < 8; ++k) columns[k] = fields[k].v;
  transpose(columns, rows);
  for (int k = 0; k < 8; ++k) _mm512_store_pd(&body[k].x, rows[k].v);
}

inline void store_forces(ContactForce* out, Vec x, Vec y, Vec z, Vec w) {
  const __m512d a = _mm512_unpacklo_pd(x.v, y.v), b = _mm512_unpackhi_pd(x.v, y.v);
  const __m512d c = _mm512_unpacklo_pd(z.v, w.v), d = _mm512_unpackhi_pd(z.v, w.v);
  // 128-bit block k of a: x,y of lane 2k; of b: of lane 2k+1; c, d the same for z,w.
  const __m512i first = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11);
  const __m512i second = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
  const __m512d even_low = _mm512_permutex2var_pd(a, first, c), odd_low = _mm512_permutex2var_pd(b, first, d);
  const __m512d even_high = _mm512_permutex2var_pd(a, second, c),
                odd_high = _mm512_permutex2var_pd(b, second, d);
  double* p = &out->x;
  _mm512_store_pd(p, _mm512_shuffle_f64x2(even_low, odd_low, 0x44));
  _mm512_store_pd(p + 8, _mm512_shuffle_f64x2(even_low, odd_low, 0xee));
  _mm512_store_pd(p + 16, _mm512_shuffle_f64x2(even_high, odd_high, 0x44));
  _mm512_store_pd(p + 24, _mm512_shuffle_f64x2(even_high, odd_high, 0xee));
}

#elif defined(__AVX2__)

inline constexpr int kLanes = 4;

struct Vec {
  __m256d v;
};
struct Int {
  __m256i v;
};
struct Mask {
  __m256d v;
};

inline Vec all(double x) { return {_mm256_set1_pd(x)}; }
inline Int all_int(std::int64_t x) { return {_mm256_set1_epi64x(x)}; }
inline Vec load(const double* p) { return {_mm256_load_pd(p)}; }
inline Vec load_anywhere(const double* p) { return {_mm256_loadu_pd(p)}; }
inline void store(double* p, Vec a) { _mm256_store_pd(p, a.v); }
inline void store_anywhere(double* p, Vec a) { _mm256_storeu_pd(p, a.v); }
inline Vec operator+(Vec a, Vec b) { return {_mm256_add_pd(a.v, b.v)}; }
inline Vec operator-(Vec a, Vec b) { return {_mm256_sub_pd(a.v, b.v)}; }
inline Vec operator*(Vec a, Vec b) { return {_mm256_mul_pd(a.v, b.v)}; }
inline Vec operator/(Vec a, Vec b) { return {_mm256_div_pd(a.v, b.v)}; }
inline Vec fma(Vec a, Vec b, Vec c) { return {_mm256_fmadd_pd(a.v, b.v, c.v)}; }
inline Vec sqrt(Vec a) { return {_mm256_sqrt_pd(a.v)}; }
inline Vec max(Vec a, Vec b) { return {_mm256_max_pd(a.v, b.v)}; }
inline Vec min(Vec a, Vec b) { return {_mm256_min_pd(a.v, b.v)}; }
inline Mask greater(Vec a, Vec b) { return {_mm256_cmp_pd(a.v, b.v, _CMP_GT_OQ)}; }
inline Mask both(Mask a, Mask b) { return {_mm256_and_pd(a.v, b.v)}; }
inline bool any(Mask m) { return _mm256_movemask_pd(m.v) != 0; }
inline int count(Mask m) { return __builtin_popcount(static_cast<unsigned>(_mm256_movemask_pd(m.v))); }
inline Mask first_lanes(int n) {
  return {_mm256_castsi256_pd(_mm256_cmpgt_epi64(_mm256_set1_epi64x(n), _mm256_setr_epi64x(0, 1, 2, 3)))};
}
inline Vec select(Mask m, Vec yes, Vec no) { return {_mm256_blendv_pd(no.v, yes.v, m.v)}; }
inline Vec keep(Mask m, Vec a) { return {_mm256_and_pd(m.v, a.v)}; }
/// Both are false for what is no number.
inline Mask differ(Vec a, Vec b) { return {_mm256_cmp_pd(a.v, b.v, _CMP_NEQ_OQ)}; }
inline Mask equal(Vec a, Vec b) { return {_mm256_cmp_pd(a.v, b.v, _CMP_EQ_OQ)}; }
inline Int bits(Vec a) { return {_mm256_castpd_si256(a.v)}; }
inline Vec from_bits(Int a) { return {_mm256_castsi256_pd(a.v)}; }
inline Int operator+(Int a, Int b) { return {_mm256_add_epi64(a.v, b.v)}; }
inline Int operator-(Int a, Int b) { return {_mm256_sub_epi64(a.v, b.v)}; }
inline Int operator&(Int a, Int b) { return {_mm256_and_si256(a.v, b.v)}; }
inline Int operator|(Int a, Int b) { return {_mm256_or_si256(a.v, b.v)}; }
inline Int shift_right(Int a, int n) { return {_mm256_srl_epi64(a.v, _mm_cvtsi32_si128(n))}; }
inline void store(std::int64_t* p, Int a) { _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), a.v); }
inline std::int64_t sum(Int a) {
  std::int64_t lane[4];
  store(lane, a);
  return lane[0] + lane[1] + lane[2] + lane[3];
}

/// Rows r[0..3] of four doubles each become columns.
inline void transpose(const __m256d r[4], Vec out[4]) {
  const __m256d a = _mm256_unpacklo_pd(r[0], r[1]), b = _mm256_unpackhi_pd(r[0], r[1]);
  const __m256d c = _mm256_unpacklo_pd(r[2], r[3]), d = _mm256_unpackhi_pd(r[2], r[3]);
  out[0].v = _mm256_permute2f128_pd(a, c, 0x20);
  out[1].v = _mm256_permute2f128_pd(b, d, 0x20);
  out[2].v = _mm256_permute2f128_pd(a, c, 0x31);
  out[3].v = _mm256_permute2f128_pd(b, d, 0x31);
}

/// Fields x, y, z, radius, vx, vy, vz, breaking_stress of four bodies.
inline void load_bodies(const Body* body, const std::int32_t* index, Vec out[8]) {
  __m256d low[4], high[4];
  for (int k = 0; k < 4; ++k) {
    low[k] = _mm256_load_pd(&body[index[k]].x);
    high[k] = _mm256_load_pd(&body[index[k]].vx);
  }
  transpose(low, out);
  transpose(high, out + 4);
}

inline Vec load_radii(const Body* body, const std::int32_t* index) {
  const __m128i place = _mm_slli_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(index)), 3);
  const __m256d none = _mm256_setzero_pd();
  return {_mm256_mask_i32gather_pd(none, &body->radius, place, _mm256_cmp_pd(none, none, _CMP_EQ_OQ),
                                   sizeof(double))};
}

/// Of four pairs of bodies: second minus first of x, y, z and vx, vy, vz; the sum of the radii; the smaller
/// breaking stress.
inline void load_pairs(const Body* body, const std::int32_t* first, const std::int32_t* second, Vec out[8]) {
  __m256d low[4], high[4];
  for (int k = 0; k < 4; ++k) {
    const __m256d a = _mm256_load_pd(&body[first[k]].x), b = _mm256_load_pd(&body[second[k]].x);
    const __m256d c = _mm256_load_pd(&body[first[k]].vx), d = _mm256_load_pd(&body[second[k]].vx);
    low[k] = _mm256_blend_pd(_mm256_sub_pd(b, a), _mm256_add_pd(a, b), 0x8);
    high[k] = _mm256_blend_pd(_mm256_sub_pd(d, c), _mm256_min_pd(c, d), 0x8);
  }
  transpose(low, out);
  transpose(high, out + 4);
}

inline Int load_indices(const std::int32_t* p) {
  return {_mm256_cvtepi32_epi64(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p)))};
}

/// Four doubles at p + 4 index for each lane, as four vectors.
inline void load_quads(const double* p, Int index, Vec out[4]) {
  std::int64_t at[4];
  store(at, index);
  __m256d rows[4];
  for (int k = 0; k < 4; ++k) rows[k] = _mm256_load_pd(p + 4 * at[k]);
  transpose(rows, out);
}

inline void load_consecutive_quads(const double* p, Vec out[4]) {
  __m256d rows[4];
  for (int k = 0; k < 4; ++k) rows[k] = _mm256_load_pd(p + 4 * k);
  transpose(rows, out);
}

inline void load_consecutive_bodies(const Body* body, Vec out[8]) {
  __m256d low[4], high[4];
  for (int k = 0; k < 4; ++k) {
    low[k] = _mm256_load_pd(&body[k].x);
    high[k] = _mm256_load_pd(&body[k].vx);
  }
  transpose(low, out);
  transpose(high, out + 4);
}

inline void store_consecutive_bodies(Body* body, const Vec fields[8]) {
  __m256d low[4], high[4];
  Vec rows[8];
  for (int k = 0; k < 4; ++k) {
    low[k] = fields[k].v;
    high[k] = fields[4 + k].v;
  }
  transpose(low, rows);
  transpose(high, rows + 4);
  for (int k = 0; k < 4; ++k) {
    _mm256_store_pd(&body[k].x, rows[k].v);
    _mm256_store_pd(&body[k].vx, rows[4 + k].v);
  }
}

inline void store_forces(ContactForce* out, Vec x, Vec y, Vec z, Vec w) {
  const __m256d rows[4] = {x.v, y.v, z.v, w.v};
  Vec columns[4];
  transpose(rows, columns);
  for (int k = 0; k < 4; ++k) _mm256_store_pd(&out[k].x, columns[k].v);
}

#endif

/// |size| with the sign of `like`, and 0 where that is 0.
inline Vec with_sign(Vec size, Vec like) {
  const Int sign = all_int(INT64_MIN), magnitude = all_int(INT64_MAX);
  return keep(differ(like, all(0.0)), from_bits((bits(size) & magnitude) | (bits(like) & sign)));
}

/// Rounded to integers by the exponent trick; lanes outside the mask count nothing.
inline Int to_quanta(Mask mask, Vec value, double scale) {
  const Vec clamped = min(max(value * all(scale), all(-quanta::kLimit)), all(quanta::kLimit));
  return bits(keep(mask, clamped) + all(quanta::kMagic)) - bits(all(quanta::kMagic));
}

}  // namespace creep::CREEP_KERNEL_NAMESPACE

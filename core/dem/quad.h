// Four doubles that move together: the vectors of one particle in the particle kernel. (kernel)
//
// With AVX2 one register, else an array; lane by lane the same operations, so the same bits. Names live in
// the namespace of the instruction set they are compiled for.
#pragma once

#include <cstdint>

#if defined(__AVX2__)
#include <immintrin.h>
#endif

namespace creep::CREEP_KERNEL_NAMESPACE {

#if defined(__AVX2__)

struct Quad {
  __m256d v;
};

inline Quad quad_all(double a) { return {_mm256_set1_pd(a)}; }
/// `a` in one lane, 0 in the others.
inline Quad in_lane(unsigned lane, double a) {
  alignas(32) static constexpr std::int64_t kMasks[4][4] = {
      {-1, 0, 0, 0}, {0, -1, 0, 0}, {0, 0, -1, 0}, {0, 0, 0, -1}};
  const __m256i mask = _mm256_load_si256(reinterpret_cast<const __m256i*>(kMasks[lane]));
  return {_mm256_and_pd(_mm256_set1_pd(a), _mm256_castsi256_pd(mask))};
}
inline Quad load_quad(const double* p) { return {_mm256_load_pd(p)}; }
inline void store_quad(double* p, Quad a) { _mm256_store_pd(p, a.v); }
inline Quad operator+(Quad a, Quad b) { return {_mm256_add_pd(a.v, b.v)}; }
inline Quad operator-(Quad a, Quad b) { return {_mm256_sub_pd(a.v, b.v)}; }
inline Quad operator*(Quad a, Quad b) { return {_mm256_mul_pd(a.v, b.v)}; }
/// |size| with the sign of `like`, and 0 where that is 0.
inline Quad with_sign(Quad size, Quad like) {
  const __m256d sign_bit = _mm256_set1_pd(-0.0);
  const __m256d moving = _mm256_cmp_pd(like.v, _mm256_setzero_pd(), _CMP_NEQ_OQ);
  const __m256d bits = _mm256_or_pd(_mm256_andnot_pd(sign_bit, size.v), _mm256_and_pd(sign_bit, like.v));
  return {_mm256_and_pd(bits, moving)};
}
/// Lanes 0, 1, 2 with the other sign.
inline Quad turned(Quad a) { return {_mm256_xor_pd(a.v, _mm256_setr_pd(-0.0, -0.0, -0.0, 0.0))}; }
/// Lanes 0, 1, 2 of a and lane 3 of b.
inline Quad three_and_one(Quad a, Quad b) { return {_mm256_blend_pd(a.v, b.v, 0x8)}; }
/// yes + b or no + b, without a branch. Who comes after waits for `yes` as long as an addition takes, or with
/// AVX2 for a choice as well.
inline Quad one_of_plus(bool which, Quad yes, Quad no, Quad b) {
#if defined(__AVX512VL__)
  const auto mask = static_cast<__mmask8>(-static_cast<int>(which));
  return {_mm256_mask_add_pd(_mm256_add_pd(no.v, b.v), mask, yes.v, b.v)};
#else
  alignas(32) static constexpr std::int64_t kMasks[2][4] = {{0, 0, 0, 0}, {-1, -1, -1, -1}};
  const __m256i mask = _mm256_load_si256(reinterpret_cast<const __m256i*>(kMasks[which]));
  return Quad{_mm256_blendv_pd(no.v, yes.v, _mm256_castsi256_pd(mask))} + b;
#endif
}

#else

struct Quad {
  double v[4];
};

inline Quad quad_all(double a) { return {{a, a, a, a}}; }
inline Quad in_lane(unsigned lane, double a) {
  Quad out = quad_all(0.0);
  out.v[lane] = a;
  return out;
}
inline Quad load_quad(const double* p) { return {{p[0], p[1], p[2], p[3]}}; }
inline void store_quad(double* p, Quad a) {
  for (int k = 0; k < 4; ++k) p[k] = a.v[k];
}
inline Quad operator+(Quad a, Quad b) {
  return {{a.v[0] + b.v[0], a.v[1] + b.v[1], a.v[2] + b.v[2], a.v[3] + b.v[3]}};
}
inline Quad operator-(Quad a, Quad b) {
  return {{a.v[0] - b.v[0], a.v[1] - b.v[1], a.v[2] - b.v[2], a.v[3] - b.v[3]}};
}
inline Quad operator*(Quad a, Quad b) {
  return {{a.v[0] * b.v[0], a.v[1] * b.v[1], a.v[2] * b.v[2], a.v[3] * b.v[3]}};
}
/// |size| with the sign of `like`, and 0 where that is 0.
inline Quad with_sign(Quad size, Quad like) {
  Quad out{};
  for (int k = 0; k < 4; ++k) {
    out.v[k] = like.v[k] != 0.0 ? __builtin_copysign(__builtin_fabs(size.v[k]), like.v[k]) : 0.0;
  }
  return out;
}
/// Lanes 0, 1, 2 with the other sign.
inline Quad turned(Quad a) { return {{-a.v[0], -a.v[1], -a.v[2], a.v[3]}}; }
/// Lanes 0, 1, 2 of a and lane 3 of b.
inline Quad three_and_one(Quad a, Quad b) { return {{a.v[0], a.v[1], a.v[2], b.v[3]}}; }

#endif

}  // namespace creep::CREEP_KERNEL_NAMESPACE

// The contact kernel, plain: one contact at a time, as the model reads. The oracle of the vector kernels.
// (kernel)
//
// Symbols (eqs 1-5, 12): E' reduced modulus, r' reduced radius, delta overlap, n normal from first to second,
// fn normal force, kn = dF/d(delta), kt tangential stiffness, mu friction. Products and sums are fused
// exactly where std::fma stands, in every instruction set.
#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "core/dem/kernels.h"
#include "core/physics/contact_law.h"

namespace creep {
namespace {

void evaluate(const LawView& law, double overlap, double& g, double& slope) {
  if (overlap >= law.delta_T2) {
    const double depth = overlap - law.hertz_offset;
    const double root = std::sqrt(depth);
    g = (LawTable::kFourThirds * depth) * root;
    slope = 2.0 * root;
    return;
  }
  const double u = overlap * law.inverse_delta_T1;
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(u);
  std::int64_t cell = static_cast<std::int64_t>(bits >> law.cell_shift) - law.before_first_cell;
  double base = std::bit_cast<double>(bits & static_cast<std::uint64_t>(law.base_mask));
  if (u < LawTable::kFirstBorder) {
    cell = 0;
    base = 0.0;
  }
  const double* c = law.cells + 4 * cell;
  const double x = u - base;
  const double p2 = std::fma(c[3], x, c[2]);
  const double p1 = std::fma(p2, x, c[1]);
  g = std::fma(p1, x, c[0]);
  slope = std::fma(std::fma(c[3], x, p2), x, p1) * law.inverse_delta_T1;
}

std::int64_t to_quanta(double value, double scale) {
  const double clamped = std::min(std::max(value * scale, -quanta::kLimit), quanta::kLimit);
  return std::bit_cast<std::int64_t>(clamped + quanta::kMagic) - std::bit_cast<std::int64_t>(quanta::kMagic);
}

double dot(double ax, double ay, double az, double bx, double by, double bz) {
  return std::fma(ax, bx, std::fma(ay, by, az * bz));
}

/// Straight to the particles where no other thread adds to them, else to the slot.
void hand_over(const ContactPhase& phase, CycleKind kind, std::size_t c, const ContactForce& f,
               double stress) {
  const std::uint8_t deferred = phase.deferred[c];
  if (deferred != 0) phase.force[c] = f;
  if (deferred != 0 && kind.measure) phase.stress[c] = stress;
  const auto add = [&](std::int32_t particle, double sign) {
    ContactForce& sum = phase.resultant[particle];
    sum = {sum.x + sign * f.x, sum.y + sign * f.y, sum.z + sign * f.z, sum.stiffness + f.stiffness};
    if (kind.measure) phase.peak_stress[particle] = std::max(phase.peak_stress[particle], stress);
  };
  if ((deferred & kDeferFirst) == 0) add(phase.first[c], 1.0);
  if ((deferred & kDeferSecond) == 0) add(phase.second[c], -1.0);
}

void one_contact(const ContactPhase& phase, CycleKind kind, std::size_t c, ContactSums& sums) {
  const Body& a = phase.body[phase.first[c]];
  const Body& b = phase.body[phase.second[c]];
  const double dx = b.x - a.x, dy = b.y - a.y, dz = b.z - a.z;
  const double distance = std::sqrt(dot(dx, dy, dz, dx, dy, dz));
  const double reach = a.radius + b.radius;
  const double overlap = reach - distance;
  if (!(overlap > 0.0)) {
    phase.shear_x[c] = phase.shear_y[c] = phase.shear_z[c] = 0.0;
    if (phase.spin != nullptr) phase.couple[c] = {0.0, 0.0, 0.0, 0.0};
    hand_over(phase, kind, c, {0.0, 0.0, 0.0, 0.0}, 0.0);
    return;
  }
  const double inverse = 1.0 / distance;
  const double nx = dx * inverse, ny = dy * inverse, nz = dz * inverse;
  double g, slope;
  evaluate(phase.law, overlap, g, slope);
  const double root_radius = phase.root_radius[c];
  const double prefactor = phase.modulus * root_radius;
  const double fn = prefactor * g;
  const double kn = prefactor * slope;
  const double kt = phase.tangential_ratio * kn;

  // Tangential displacement of second over first in the last drift.
  double vx = b.vx - a.vx, vy = b.vy - a.vy, vz = b.vz - a.vz;
  if (phase.spin != nullptr) {
    // Surfaces at the contact lag behind the centres by w x n, w = r1 omega1 + r2 omega2.
    const Spin& p = phase.spin[phase.first[c]];
    const Spin& q = phase.spin[phase.second[c]];
    const double wx = std::fma(a.radius, p.x, b.radius * q.x), wy = std::fma(a.radius, p.y, b.radius * q.y),
                 wz = std::fma(a.radius, p.z, b.radius * q.z);
    vx = vx - std::fma(wy, nz, 0.0 - wz * ny);
    vy = vy - std::fma(wz, nx, 0.0 - wx * nz);
    vz = vz - std::fma(wx, ny, 0.0 - wy * nx);
  }
  const double ux = vx * phase.drift, uy = vy * phase.drift, uz = vz * phase.drift;
  const double un = dot(ux, uy, uz, nx, ny, nz);
  const double sx = std::fma(0.0 - un, nx, ux), sy = std::fma(0.0 - un, ny, uy),
               sz = std::fma(0.0 - un, nz, uz);
  // The old force turned into the new tangent plane, then the increment, then Coulomb.
  const double ox = phase.shear_x[c], oy = phase.shear_y[c], oz = phase.shear_z[c];
  const double on = dot(ox, oy, oz, nx, ny, nz);
  double tx = std::fma(kt, sx, std::fma(0.0 - on, nx, ox));
  double ty = std::fma(kt, sy, std::fma(0.0 - on, ny, oy));
  double tz = std::fma(kt, sz, std::fma(0.0 - on, nz, oz));
  const double squared = dot(tx, ty, tz, tx, ty, tz);
  const double cap = phase.friction * fn;
  if (squared > cap * cap) {
    const double trial = std::sqrt(squared);
    const double scale = cap / trial;
    tx = tx * scale;
    ty = ty * scale;
    tz = tz * scale;
    sums.friction += to_quanta((trial - cap) * cap / kt, 0x1p70);
  }
  sums.tangential_work += to_quanta(0.5 * dot(ox + tx, oy + ty, oz + tz, sx, sy, sz), 0x1p70);
  phase.shear_x[c] = tx;
  phase.shear_y[c] = ty;
  phase.shear_z[c] = tz;
  if (phase.spin != nullptr) {
    phase.couple[c] = {std::fma(ny, tz, 0.0 - nz * ty), std::fma(nz, tx, 0.0 - nx * tz),
                       std::fma(nx, ty, 0.0 - ny * tx), 0.0};
  }
  const double fx = std::fma(0.0 - fn, nx, tx), fy = std::fma(0.0 - fn, ny, ty),
               fz = std::fma(0.0 - fn, nz, tz);
  const double area = root_radius * root_radius * overlap;  // eq 12, over pi
  hand_over(phase, kind, c, {fx, fy, fz, kind.measure ? kn : 0.0}, fn / (std::numbers::pi * area));
  if (kind.check && fn > std::min(a.breaking_stress, b.breaking_stress) * area) sums.breaking = true;
  if (kind.measure) {
    sums.force += to_quanta(std::sqrt(dot(fx, fy, fz, fx, fy, fz)), 0x1p40);
    sums.overlap += to_quanta(overlap, 0x1p60);
    ++sums.touching;
    sums.largest_overlap_ratio = std::max(sums.largest_overlap_ratio, overlap / std::min(a.radius, b.radius));
  }
}

void contacts(const ContactPhase& phase, CycleKind kind, std::size_t begin, std::size_t end,
              ContactSums& sums) {
  for (std::size_t c = begin; c < end; ++c) one_contact(phase, kind, c, sums);
}

}  // namespace
}  // namespace creep

#define CREEP_KERNEL_NAMESPACE scalar
#include "core/dem/particle_kernel.h"

namespace creep {

const Kernels& portable_kernels() {
  static constexpr Kernels kKernels{"portable", &contacts, &scalar::particles};
  return kKernels;
}

}  // namespace creep

#include "tests/validation/fcc_lattice.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>

namespace creep::validation {
namespace {

/// Of the unit cell.
const std::array<Eigen::Vector3d, 4> kPlaces = {
    {{0.0, 0.0, 0.0}, {0.5, 0.5, 0.0}, {0.5, 0.0, 0.5}, {0.0, 0.5, 0.5}}};
/// Half of the neighbours; the other half are the same contacts seen from the other end.
const std::array<Eigen::Vector3d, 6> kBranches = {{{0.5, 0.5, 0.0},
                                                   {0.5, -0.5, 0.0},
                                                   {0.5, 0.0, 0.5},
                                                   {0.5, 0.0, -0.5},
                                                   {0.0, 0.5, 0.5},
                                                   {0.0, 0.5, -0.5}}};

}  // namespace

FccLattice::FccLattice(const ContactModel& model, const Kernels& kernels, double radius, double overlap,
                       double friction)
    : model_(&model),
      kernels_(&kernels),
      friction_(friction),
      cell_(Eigen::Matrix3d::Identity() * std::sqrt(2.0) * (2.0 * radius - overlap)) {
  const auto add_body = [&](const Eigen::Vector3d& place) {
    const Eigen::Vector3d x = cell_ * place;
    body_.push_back({x.x(), x.y(), x.z(), radius, 0.0, 0.0, 0.0, std::numeric_limits<double>::infinity()});
  };
  for (const Eigen::Vector3d& place : kPlaces) add_body(place);
  for (std::size_t i = 0; i < kSpheres; ++i) {
    for (const Eigen::Vector3d& branch : kBranches) {
      const Eigen::Vector3d there = kPlaces[i] + branch;
      for (std::size_t j = 0; j < kSpheres; ++j) {
        const Eigen::Vector3d offset = there - kPlaces[j];
        if ((offset - offset.array().round().matrix()).norm() > 1e-9) continue;  // not a whole cell away
        first_.push_back(static_cast<std::int32_t>(i));
        second_.push_back(static_cast<std::int32_t>(body_.size()));
        images_.push_back({body_.size(), j, offset.array().round()});
        add_body(there);
      }
    }
  }
  root_radius_.assign(kContacts, std::sqrt(0.5 * radius));
  shear_x_.resize(kContacts);
  shear_y_.resize(kContacts);
  shear_z_.resize(kContacts);
  stress_.resize(kContacts);
  force_.resize(kContacts);
  resultant_.resize(body_.size());
  deferred_.assign(kContacts, 0);
  all_deferred_.assign(kContacts, kDeferFirst | kDeferSecond);
}

void FccLattice::refresh_images() {
  for (const Image& image : images_) {
    const Eigen::Vector3d x = position(image.of) + cell_ * image.offset;
    Body& body = body_[image.body];
    const Body& original = body_[image.of];
    body.x = x.x();
    body.y = x.y();
    body.z = x.z();
    body.vx = original.vx;
    body.vy = original.vy;
    body.vz = original.vz;
  }
}

void FccLattice::compute_contacts(bool measure, double last_drift) {
  ContactPhase phase;
  phase.body = body_.data();
  phase.first = first_.data();
  phase.second = second_.data();
  phase.root_radius = root_radius_.data();
  phase.shear_x = shear_x_.data();
  phase.shear_y = shear_y_.data();
  phase.shear_z = shear_z_.data();
  phase.force = force_.data();
  phase.resultant = resultant_.data();
  phase.deferred = measure ? all_deferred_.data() : deferred_.data();
  phase.stress = stress_.data();
  AlignedVector<double> peak_stress(resultant_.size(), 0.0);
  phase.peak_stress = peak_stress.data();
  phase.law = model_->view();
  phase.modulus = model_->modulus;
  phase.tangential_ratio = model_->tangential_ratio;
  phase.friction = friction_;
  phase.drift = last_drift;
  ContactSums sums;
  kernels_->contacts(phase, {measure, false, true}, 0, kContacts, sums);
}

Eigen::Matrix3d FccLattice::stress() {
  refresh_images();
  compute_contacts(true, 0.0);
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t c = 0; c < kContacts; ++c) {
    const Eigen::Vector3d on_first(force_[c].x, force_[c].y, force_[c].z);
    const Eigen::Vector3d branch =
        position(static_cast<std::size_t>(second_[c])) - position(static_cast<std::size_t>(first_[c]));
    sum -= on_first * branch.transpose();
  }
  return sum / cell_.determinant();
}

void FccLattice::strain(const Eigen::Matrix3d& by) {
  cell_ -= by * cell_;
  for (Body& body : body_) {
    const Eigen::Vector3d v = -by * Eigen::Vector3d(body.x, body.y, body.z);
    body.x += v.x();
    body.y += v.y();
    body.z += v.z();
    body.vx = v.x();
    body.vy = v.y();
    body.vz = v.z();
  }
  compute_contacts(true, 1.0);  // velocities are the displacements of a second
  for (Body& body : body_) body.vx = body.vy = body.vz = 0.0;
}

void FccLattice::move(double drift) {
  refresh_images();
  compute_contacts(false, last_drift_);
  for (const Image& image : images_) {
    ContactForce &sum = resultant_[image.of], &extra = resultant_[image.body];
    sum = {sum.x + extra.x, sum.y + extra.y, sum.z + extra.z, 0.0};
    extra = {};
  }
  const std::vector<std::uint8_t> none(kSpheres, 0);
  const std::vector<double> unit_mass(kSpheres, 1.0);
  const AlignedVector<ListReference> everywhere(kSpheres, {0.0, 0.0, 0.0, 1.0});
  ParticlePhase phase;
  phase.body = body_.data();
  phase.resultant = resultant_.data();
  phase.shared = none.data();
  phase.near_walls = none.data();
  phase.reference = everywhere.data();
  phase.inertial_mass = unit_mass.data();
  phase.law = model_->view();
  phase.kick = 0.5 * (last_drift_ + drift);
  phase.drift = drift;
  ParticleSums sums;
  kernels_->particles(phase, {false, false, true}, 0, kSpheres, sums);
  last_drift_ = drift;
}

void FccLattice::set_velocity(std::size_t sphere, const Eigen::Vector3d& velocity) {
  body_[sphere].vx = velocity.x();
  body_[sphere].vy = velocity.y();
  body_[sphere].vz = velocity.z();
}

double FccLattice::kinetic_energy() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < kSpheres; ++i) {
    const Body& b = body_[i];
    sum += 0.5 * (b.vx * b.vx + b.vy * b.vy + b.vz * b.vz);
  }
  return sum;
}

}  // namespace creep::validation

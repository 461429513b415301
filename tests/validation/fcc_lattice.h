// A face-centred cubic lattice of equal spheres without boundary, driven by the product's kernels.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "core/dem/contact_model.h"
#include "core/dem/kernels.h"
#include "core/dem/specimen.h"

namespace creep::validation {

/// The four spheres of one cubic cell and their 24 contacts. Where a contact crosses the border of the cell
/// its second sphere is an image, a body of its own that follows its original.
class FccLattice {
 public:
  /// @param overlap  of all contacts [m].
  FccLattice(const ContactModel& model, const Kernels& kernels, double radius, double overlap,
             double friction = 1.0);

  /// Love-Weber, compression positive, of the contacts as they stand [Pa]. Nothing moves.
  Eigen::Matrix3d stress();

  /// Strains the cell, and all in it, by a symmetric tensor, compression positive. Shear springs follow.
  void strain(const Eigen::Matrix3d& by);

  /// Contacts, kick and drift without damping, as in a cycle. @param drift  step [s].
  void move(double drift);

  void set_velocity(std::size_t sphere, const Eigen::Vector3d& velocity);
  double kinetic_energy() const;  ///< per mass of a sphere [m2/s2]

 private:
  static constexpr std::size_t kSpheres = 4, kContacts = 24;
  struct Image {
    std::size_t body, of;
    Eigen::Vector3d offset;  // in cells
  };

  void refresh_images();
  void compute_contacts(bool measure, double last_drift);
  Eigen::Vector3d position(std::size_t body) const { return {body_[body].x, body_[body].y, body_[body].z}; }

  const ContactModel* model_;
  const Kernels* kernels_;
  double friction_;
  Eigen::Matrix3d cell_;  // columns are its edges [m]
  std::vector<Image> images_;
  AlignedVector<Body> body_;  // the spheres, then their images
  std::vector<std::int32_t> first_, second_;
  AlignedVector<double> root_radius_, shear_x_, shear_y_, shear_z_, stress_;
  AlignedVector<ContactForce> force_, resultant_;
  std::vector<std::uint8_t> deferred_, all_deferred_;
  double last_drift_ = 0.0;
};

}  // namespace creep::validation

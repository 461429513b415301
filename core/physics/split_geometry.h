// How a broken particle is replaced: 14 spheres inside it, all tangent to it, none overlapping.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "core/experiment/experiment.h"

namespace creep {

inline constexpr std::size_t kSiblingCount = 14;

/// In units of the parent's radius, in the frame whose z axis is the normal of the parent's largest contact
/// force.
struct Sibling {
  Eigen::Vector3d centre;  ///< from the parent's centre [-]
  double radius = 0.0;     ///< [-]
};

/// The siblings in the order in which they get their ids, larger ones first:
///  - octahedral: 6 on the axes (+x, -x, +y, -y, +z, -z), then 8 along <111>;
///  - cubic: 8 along <111>, then 6 on the axes;
///  - tetrahedral: 4 at the corners of a tetrahedron, the first on +z; 4 opposite them; 6 above its edges.
const std::array<Sibling, kSiblingCount>& sibling_layout(SplitLayout layout);

/// Volume of the siblings over the parent's [-]; the rest becomes fines.
double kept_volume_fraction(SplitLayout layout);

/// Radius of the smallest sibling over the parent's [-]: the coarse end of the fines of the event.
double smallest_sibling_radius(SplitLayout layout);

/// Proper rotation that takes +z to the unit vector `axis`, then turns by `azimuth_turn` (in turns) about it;
/// without cancellation for any axis. Where the azimuth starts is arbitrary and jumps where axis.z() changes
/// sign.
Eigen::Matrix3d rotation_from_z(const Eigen::Vector3d& axis, double azimuth_turn);

}  // namespace creep

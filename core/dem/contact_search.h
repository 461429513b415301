// Neighbour search: which pairs may touch before anything has moved by half a skin. (kernel)
//
// One grid a size class (diameters within a factor of two), so that fragments ten times smaller than the rest
// cost no more than their number. Each pair is found once, by its finer member. The result does not depend on
// threads, and no result of a run depends on the list: pairs that do not touch contribute nothing.
//
// Every particle has a reach of its own, how far it may go before the list must be made anew: half a skin, or
// as far as it flies in kHorizon steps. So the few fast free fragments after a breakage do not force a search
// every few cycles.
#pragma once

#include <cstdint>
#include <vector>

#include "core/dem/specimen.h"
#include "core/dem/team.h"

namespace creep {

class ContactSearch {
 public:
  /// @param skin  gap up to which a pair of particles at rest is listed [m].
  explicit ContactSearch(double skin) : skin_(skin) {}

  /// Makes specimen.contacts anew and carries the shear forces over.
  ///
  /// @param new_index  where each particle of the old list went, -1 if it broke; nullptr if none did.
  /// Fragments
  ///                   stand behind all survivors, so the map rises.
  void search(Specimen& specimen, Team& team, const std::vector<std::int32_t>* new_index);

  double skin() const { return skin_; }
  std::int64_t searches() const { return searches_; }

 private:
  struct Pair {
    std::int32_t first, second;
  };
  struct Entry {
    double x, y, z, extent;  // extent: radius + reach
    std::int32_t index;
  };
  struct Level {
    double cell = 0.0;               // edge [m]
    double max_radius = 0.0;         // [m]
    double max_reach = 0.0;          // [m]
    std::array<int, 3> cells{};      // a side
    std::array<double, 3> origin{};  // [m]
    std::vector<std::int32_t> members;
    std::vector<std::int32_t> begin;  // of each cell in entries, x fastest
    std::vector<Entry> entries;
  };

  double reach_of(const Body& body, double time_step) const;
  void sort_into_levels(const Specimen& specimen);
  void fill_level(Level& level, const Specimen& specimen);
  void find_pairs(const Body& body, std::int32_t index, std::size_t own_level,
                  std::vector<Pair>& found) const;
  void lay_rows(Specimen& specimen, Team& team);
  void share_out(Contacts& contacts, std::size_t particles, const Team& team) const;
  void carry_shear(Contacts& contacts, Team& team, const std::vector<std::int32_t>* new_index);

  double skin_;
  std::int64_t searches_ = 0;
  std::vector<Level> levels_;
  std::vector<std::uint8_t> level_of_;
  std::vector<double> reach_;             // of each particle [m]
  std::vector<std::vector<Pair>> found_;  // a thread each
  // The list before this search, for the shear forces.
  std::vector<std::int32_t> old_begin_, old_second_;
  AlignedVector<double> old_x_, old_y_, old_z_;
};

}  // namespace creep

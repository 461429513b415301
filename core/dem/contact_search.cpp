#include "core/dem/contact_search.h"

#include <algorithm>
#include <cmath>

#include "core/arithmetic/check.h"
#include "core/arithmetic/elementary.h"
#include "core/dem/kernels.h"

namespace creep {
namespace {

int clamp_cell(double coordinate, int cells) {
  // What is no number has a cell too: the guard that ends such a run looks at measuring cycles only.
  const double bounded = coordinate > -1.0 ? std::min(coordinate, static_cast<double>(cells)) : -1.0;
  return std::clamp(static_cast<int>(std::floor(bounded)), 0, cells - 1);
}

/// The particle kernel, which ends the contacts with walls, does not come by those that are far off.
void forget_far_walls(WallShear& shear, unsigned near) {
  for (unsigned axis = 0; axis < 3; ++axis) {
    if ((near >> (2 * axis) & 3u) == 0) shear.across[axis][0] = shear.across[axis][1] = 0.0;
  }
}

/// Borders such that all members have about the same to do, on multiples of the kernel's grain.
void share_out_particles(Contacts& contacts, const Team& team) {
  constexpr std::size_t kSpecialWork = 3;  // what completing a special particle takes, in moves of a particle
  const std::size_t n = contacts.near_walls.size();
  const auto members = static_cast<std::size_t>(team.size());
  const std::size_t work = n + kSpecialWork * contacts.special.size();
  contacts.particle_shares.assign(members + 1, n);
  contacts.particle_shares[0] = 0;
  std::size_t done = 0, next = 0, member = 1;
  for (std::size_t i = 0; i < n && member < members; i += kKernelGrain) {
    for (; member < members && done * members >= work * member; ++member)
      contacts.particle_shares[member] = i;
    done += kKernelGrain;
    for (; next < contacts.special.size() &&
           static_cast<std::size_t>(contacts.special[next]) < i + kKernelGrain;
         ++next)
      done += kSpecialWork;
  }
}

}  // namespace

void ContactSearch::search(Specimen& specimen, Team& team, const std::vector<std::int32_t>* new_index) {
  Contacts& contacts = specimen.contacts;
  const std::size_t n = specimen.particles.size();
  old_begin_.swap(contacts.own_begin);
  old_second_.swap(contacts.second);
  old_x_.swap(contacts.shear_x);
  old_y_.swap(contacts.shear_y);
  old_z_.swap(contacts.shear_z);

  reach_.resize(n);
  for (std::size_t i = 0; i < n; ++i) reach_[i] = reach_of(specimen.particles.body[i], specimen.time_step);
  sort_into_levels(specimen);
  found_.resize(static_cast<std::size_t>(team.size()));
  team.run([&](int member) {
    std::vector<Pair>& found = found_[static_cast<std::size_t>(member)];
    found.clear();
    const Share share = team.share(n, member);
    for (std::size_t i = share.begin; i < share.end; ++i) {
      find_pairs(specimen.particles.body[i], static_cast<std::int32_t>(i), level_of_[i], found);
    }
  });
  lay_rows(specimen, team);
  share_out(contacts, n, team);
  carry_shear(contacts, team, new_index);

  contacts.near_walls.resize(n);
  contacts.reference.resize(n);
  contacts.special.clear();
  for (std::size_t i = 0; i < n; ++i) {
    const Body& body = specimen.particles.body[i];
    const double centre[3] = {body.x, body.y, body.z};
    std::uint8_t near = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double reach = body.radius + reach_[i] + 0.5 * skin_;
      if (centre[axis] - specimen.walls.position[2 * axis] < reach)
        near |= static_cast<std::uint8_t>(1u << (2 * axis));
      if (specimen.walls.position[2 * axis + 1] - centre[axis] < reach) {
        near |= static_cast<std::uint8_t>(2u << (2 * axis));
      }
    }
    contacts.near_walls[i] = near;
    if (!specimen.particles.wall_shear.empty()) forget_far_walls(specimen.particles.wall_shear[i], near);
    if (near != 0 || contacts.shared[i] != 0) contacts.special.push_back(static_cast<std::int32_t>(i));
    contacts.reference[i] = {body.x, body.y, body.z, reach_[i] * reach_[i]};
  }
  share_out_particles(contacts, team);
  contacts.wall_reference = specimen.walls.position;
  contacts.valid = true;
  ++searches_;
}

double ContactSearch::reach_of(const Body& body, double time_step) const {
  constexpr double kHorizon = 200.0;  // steps
  const double flight =
      kHorizon * time_step * std::sqrt(body.vx * body.vx + body.vy * body.vy + body.vz * body.vz);
  // Beyond half a radius the longer list costs more than the searches saved.
  return std::max(0.5 * skin_, std::min(flight, 0.5 * body.radius));
}

void ContactSearch::sort_into_levels(const Specimen& specimen) {
  const auto& body = specimen.particles.body;
  const std::size_t n = body.size();
  double largest = 0.0;
  for (const Body& b : body) largest = std::max(largest, b.radius);
  levels_.clear();
  level_of_.resize(n);
  constexpr std::size_t kMostLevels = 16;
  std::vector<Level> all(kMostLevels);
  for (std::size_t i = 0; i < n; ++i) {
    std::size_t level = 0;
    for (double bound = 0.5 * largest; body[i].radius <= bound && level + 1 < kMostLevels; bound *= 0.5)
      ++level;
    level_of_[i] = static_cast<std::uint8_t>(level);
    all[level].members.push_back(static_cast<std::int32_t>(i));
    all[level].max_radius = std::max(all[level].max_radius, body[i].radius);
    all[level].max_reach = std::max(all[level].max_reach, reach_[i]);
  }
  // Coarse to fine; empty classes are dropped, so level_of_ is renumbered.
  std::array<std::uint8_t, kMostLevels> place{};
  for (std::size_t level = 0; level < kMostLevels; ++level) {
    place[level] = static_cast<std::uint8_t>(levels_.size());
    if (!all[level].members.empty()) levels_.push_back(std::move(all[level]));
  }
  for (std::size_t i = 0; i < n; ++i) level_of_[i] = place[level_of_[i]];
  for (Level& level : levels_) fill_level(level, specimen);
}

void ContactSearch::fill_level(Level& level, const Specimen& specimen) {
  const auto& body = specimen.particles.body;
  // A sparse class gets cells no finer than one member each on average.
  const double volume = specimen.walls.volume();
  const double per_member = elementary::pow(volume / static_cast<double>(level.members.size()), 1.0 / 3.0);
  level.cell = std::max(2.0 * (level.max_radius + level.max_reach), per_member);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    level.origin[axis] = specimen.walls.position[2 * axis];
    level.cells[axis] = std::max(1, static_cast<int>(specimen.walls.length(axis) / level.cell));
  }
  const std::size_t count = static_cast<std::size_t>(level.cells[0]) *
                            static_cast<std::size_t>(level.cells[1]) *
                            static_cast<std::size_t>(level.cells[2]);
  level.begin.assign(count + 1, 0);
  level.entries.resize(level.members.size());
  const double inverse = 1.0 / level.cell;
  std::vector<std::int32_t> cell_of(level.members.size());
  for (std::size_t k = 0; k < level.members.size(); ++k) {
    const Body& b = body[static_cast<std::size_t>(level.members[k])];
    const int cx = clamp_cell((b.x - level.origin[0]) * inverse, level.cells[0]);
    const int cy = clamp_cell((b.y - level.origin[1]) * inverse, level.cells[1]);
    const int cz = clamp_cell((b.z - level.origin[2]) * inverse, level.cells[2]);
    cell_of[k] = (cz * level.cells[1] + cy) * level.cells[0] + cx;
    ++level.begin[static_cast<std::size_t>(cell_of[k]) + 1];
  }
  for (std::size_t c = 0; c < count; ++c) level.begin[c + 1] += level.begin[c];
  std::vector<std::int32_t> next(level.begin.begin(), level.begin.end() - 1);
  for (std::size_t k = 0; k < level.members.size(); ++k) {
    const Body& b = body[static_cast<std::size_t>(level.members[k])];
    const auto place = static_cast<std::size_t>(next[static_cast<std::size_t>(cell_of[k])]++);
    const auto index = static_cast<std::size_t>(level.members[k]);
    level.entries[place] = {b.x, b.y, b.z, b.radius + reach_[index], level.members[k]};
  }
}

void ContactSearch::find_pairs(const Body& body, std::int32_t index, std::size_t own_level,
                               std::vector<Pair>& found) const {
  for (std::size_t l = 0; l <= own_level; ++l) {
    const Level& level = levels_[l];
    const double extent = body.radius + reach_[static_cast<std::size_t>(index)];
    const double reach = extent + level.max_radius + level.max_reach;
    const double inverse = 1.0 / level.cell;
    const double centre[3] = {body.x, body.y, body.z};
    int low[3], high[3];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = clamp_cell((centre[axis] - reach - level.origin[axis]) * inverse, level.cells[axis]);
      high[axis] = clamp_cell((centre[axis] + reach - level.origin[axis]) * inverse, level.cells[axis]);
    }
    const bool same = l == own_level;
    for (int cz = low[2]; cz <= high[2]; ++cz) {
      for (int cy = low[1]; cy <= high[1]; ++cy) {
        // Cells along x stand side by side, so a row is one range.
        const auto row = static_cast<std::size_t>((cz * level.cells[1] + cy) * level.cells[0]);
        const std::int32_t end = level.begin[row + static_cast<std::size_t>(high[0]) + 1];
        for (std::int32_t k = level.begin[row + static_cast<std::size_t>(low[0])]; k < end; ++k) {
          const Entry& entry = level.entries[static_cast<std::size_t>(k)];
          if (same && entry.index <= index) continue;
          const double dx = entry.x - body.x, dy = entry.y - body.y, dz = entry.z - body.z;
          const double limit = entry.extent + extent;
          if (dx * dx + dy * dy + dz * dz < limit * limit) {
            found.push_back({std::min(index, entry.index), std::max(index, entry.index)});
          }
        }
      }
    }
  }
}

void ContactSearch::lay_rows(Specimen& specimen, Team& team) {
  Contacts& contacts = specimen.contacts;
  const std::size_t n = specimen.particles.size();
  std::size_t m = 0;
  for (const auto& found : found_) m += found.size();
  CREEP_CHECK(m < 0x7ffffff0u, "more contacts than 32-bit indices hold");
  const std::size_t padded = (m + kKernelGrain - 1) / kKernelGrain * kKernelGrain;
  contacts.count = m;
  contacts.first.resize(padded);
  contacts.second.resize(padded);
  contacts.root_radius.resize(padded);
  contacts.force.assign(padded, ContactForce{0.0, 0.0, 0.0, 0.0});
  contacts.stress.assign(padded, 0.0);
  contacts.own_begin.assign(n + 1, 0);
  for (const auto& found : found_) {
    for (const Pair& pair : found) ++contacts.own_begin[static_cast<std::size_t>(pair.first) + 1];
  }
  for (std::size_t i = 0; i < n; ++i) contacts.own_begin[i + 1] += contacts.own_begin[i];
  std::vector<std::int32_t> next(contacts.own_begin.begin(), contacts.own_begin.end() - 1);
  for (const auto& found : found_) {
    for (const Pair& pair : found) {
      contacts.second[static_cast<std::size_t>(next[static_cast<std::size_t>(pair.first)]++)] = pair.second;
    }
  }
  const auto& body = specimen.particles.body;
  team.run([&](int member) {
    const Share share = team.share(n, member);
    for (std::size_t i = share.begin; i < share.end; ++i) {
      const auto begin = static_cast<std::size_t>(contacts.own_begin[i]);
      const auto end = static_cast<std::size_t>(contacts.own_begin[i + 1]);
      std::sort(contacts.second.begin() + static_cast<std::ptrdiff_t>(begin),
                contacts.second.begin() + static_cast<std::ptrdiff_t>(end));
      for (std::size_t c = begin; c < end; ++c) {
        const double r1 = body[i].radius;
        const double r2 = body[static_cast<std::size_t>(contacts.second[c])].radius;
        contacts.first[c] = static_cast<std::int32_t>(i);
        contacts.root_radius[c] = std::sqrt(r1 * r2 / (r1 + r2));
      }
    }
  });
  for (std::size_t c = m; c < padded; ++c) {
    contacts.first[c] = contacts.first[m - 1];
    contacts.second[c] = contacts.second[m - 1];
    contacts.root_radius[c] = contacts.root_radius[m - 1];
  }
  contacts.lower_begin.assign(n + 1, 0);
  for (std::size_t c = 0; c < m; ++c)
    ++contacts.lower_begin[static_cast<std::size_t>(contacts.second[c]) + 1];
  for (std::size_t i = 0; i < n; ++i) contacts.lower_begin[i + 1] += contacts.lower_begin[i];
  next.assign(contacts.lower_begin.begin(), contacts.lower_begin.end() - 1);
  contacts.lower_contact.resize(m);
  for (std::size_t c = 0; c < m; ++c) {
    const auto second = static_cast<std::size_t>(contacts.second[c]);
    contacts.lower_contact[static_cast<std::size_t>(next[second]++)] = static_cast<std::int32_t>(c);
  }
}

void ContactSearch::share_out(Contacts& contacts, std::size_t particles, const Team& team) const {
  contacts.resultant.assign(particles, ContactForce{0.0, 0.0, 0.0, 0.0});
  contacts.peak_stress.assign(particles, 0.0);
  contacts.shared.assign(particles, 0);
  contacts.deferred.assign(contacts.first.size(), 0);
  // Padding repeats the last contact and must not be added to its particles.
  std::fill(contacts.deferred.begin() + static_cast<std::ptrdiff_t>(contacts.count), contacts.deferred.end(),
            static_cast<std::uint8_t>(kDeferFirst | kDeferSecond));
  for (int member = 1; member < team.size(); ++member) {
    const auto border = static_cast<std::int32_t>(team.share(contacts.count, member, kKernelGrain).begin);
    for (std::size_t i = 0; i < particles; ++i) {
      // Contacts of lower neighbours come before own ones, each in ascending order.
      const std::int32_t own_begin = contacts.own_begin[i], own_end = contacts.own_begin[i + 1];
      const std::int32_t lower_begin = contacts.lower_begin[i], lower_end = contacts.lower_begin[i + 1];
      if (own_begin == own_end && lower_begin == lower_end) continue;
      const auto lower = [&](std::int32_t k) { return contacts.lower_contact[static_cast<std::size_t>(k)]; };
      const std::int32_t least = lower_begin < lower_end ? lower(lower_begin) : own_begin;
      const std::int32_t most = own_begin < own_end ? own_end - 1 : lower(lower_end - 1);
      if (least < border && most >= border) contacts.shared[i] = 1;
    }
  }
  if (team.size() == 1) return;
  for (std::size_t c = 0; c < contacts.count; ++c) {
    contacts.deferred[c] =
        static_cast<std::uint8_t>(contacts.shared[static_cast<std::size_t>(contacts.first[c])] |
                                  contacts.shared[static_cast<std::size_t>(contacts.second[c])] << 1);
  }
}

void ContactSearch::carry_shear(Contacts& contacts, Team& team, const std::vector<std::int32_t>* new_index) {
  const std::size_t padded = contacts.second.size();
  contacts.shear_x.assign(padded, 0.0);
  contacts.shear_y.assign(padded, 0.0);
  contacts.shear_z.assign(padded, 0.0);
  if (old_begin_.empty()) return;
  const std::size_t old_n = old_begin_.size() - 1;
  const auto moved = [&](std::size_t old) {
    return new_index == nullptr ? static_cast<std::int32_t>(old) : (*new_index)[old];
  };
  team.run([&](int member) {
    const Share share = team.share(old_n, member);
    for (std::size_t old = share.begin; old < share.end; ++old) {
      const std::int32_t row = moved(old);
      if (row < 0) continue;
      auto c = static_cast<std::size_t>(contacts.own_begin[static_cast<std::size_t>(row)]);
      const auto end = static_cast<std::size_t>(contacts.own_begin[static_cast<std::size_t>(row) + 1]);
      const auto old_end = static_cast<std::size_t>(old_begin_[old + 1]);
      for (auto o = static_cast<std::size_t>(old_begin_[old]); o < old_end; ++o) {
        const std::int32_t second = moved(static_cast<std::size_t>(old_second_[o]));
        if (second < 0) continue;
        while (c < end && contacts.second[c] < second) ++c;
        if (c == end) break;
        if (contacts.second[c] != second) continue;
        contacts.shear_x[c] = old_x_[o];
        contacts.shear_y[c] = old_y_[o];
        contacts.shear_z[c] = old_z_[o];
      }
    }
  });
}

}  // namespace creep

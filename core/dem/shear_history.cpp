#include "core/dem/shear_history.h"

namespace creep {

std::vector<PairShear> shear_history(const Contacts& contacts) {
  std::vector<PairShear> history;
  for (std::size_t i = 0; i + 1 < contacts.own_begin.size(); ++i) {
    for (std::int32_t k = contacts.own_begin[i]; k < contacts.own_begin[i + 1]; ++k) {
      const auto c = static_cast<std::size_t>(k);
      const double x = contacts.shear_x[c], y = contacts.shear_y[c], z = contacts.shear_z[c];
      if (x != 0.0 || y != 0.0 || z != 0.0) {
        history.push_back({static_cast<std::int32_t>(i), contacts.second[c], x, y, z});
      }
    }
  }
  return history;
}

Contacts contacts_from_history(std::size_t particles, const std::vector<PairShear>& history) {
  Contacts contacts;
  contacts.count = history.size();
  contacts.own_begin.assign(particles + 1, 0);
  for (const PairShear& pair : history) {
    ++contacts.own_begin[static_cast<std::size_t>(pair.first) + 1];
    contacts.second.push_back(pair.second);
    contacts.shear_x.push_back(pair.x);
    contacts.shear_y.push_back(pair.y);
    contacts.shear_z.push_back(pair.z);
  }
  for (std::size_t i = 0; i < particles; ++i) contacts.own_begin[i + 1] += contacts.own_begin[i];
  return contacts;
}

}  // namespace creep

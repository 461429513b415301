// ReadCurves: from the rows of a table to columns, whole or thinned.
#pragma once

#include <cstdint>

#include "absl/status/status.h"
#include "creep/v1/creep.pb.h"
#include "server/folders/sample_index.h"

namespace creepd {

/// Of the table in which `samples` samples were told. Errors: creep.proto.
absl::Status read_curves(SampleIndex& index, std::uint64_t samples,
                         const creep::v1::ReadCurvesRequest& request, creep::v1::Curves& response);

/// The columns of all tables, for GetServerInfo.
void list_columns(creep::v1::ServerInfo& info);

}  // namespace creepd

#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "formats/viewport_splitter.h"
#include "formats/viewport_table.h"
#include "scenario/frame_pattern.h"
#include "scenario/object_key.h"
#include "scenario/scenario.h"
#include "scenario/schema.h"

/// The table of scenario keys: what a file may hold and where the scenario keeps it. Reader, rules, writer, overrides,
/// sweeps, `metabuffer keys` and the documentation use it. A new key needs a member and a row.
namespace metabuffer {

/// Every place of a scenario file, in the order of the documentation.
const Schema& scenario_schema();

/// The keys outside of lists, and the maps that they are in.
const std::vector<ObjectKey<Scenario>>& setting_rows();

/// The keys of a display's correction; its file has no row, since the reader makes a table of it.
const std::vector<ObjectKey<DisplayCorrection>>& correction_rows();

/// The keys of a viewport.
const std::vector<ObjectKey<Viewport>>& viewport_rows();

/// The keys of a position on a viewport's path.
const std::vector<ObjectKey<input::PathPosition>>& path_rows();

/// A field of a table's row, in the order of files.
struct TableField {
    const char* name = nullptr;
    IntegerRange range;
    std::int64_t (*value)(const ViewportRow&) = nullptr;
    void (*set)(ViewportRow&, std::int64_t) = nullptr;
};
const std::array<TableField, 8>& table_fields();

}  // namespace metabuffer

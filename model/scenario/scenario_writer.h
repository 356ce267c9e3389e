#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "scenario/scenario.h"

namespace metabuffer {

/// The value of every scenario key that is a single value and is outside of lists ("bus.width_bits" to "64"), as
/// scenario files write it; a name without quotation marks.
std::map<std::string, std::string> scenario_settings(const Scenario& scenario);

/// Writes a scenario as files that load_scenario() reads back as an equal one: `scenario.yaml` with every key, and
/// next to it `image_N.tif` (8-bit R G B A, alpha associated, so that no reader multiplies the colours by it) and
/// `depth_N.tif` (integer Z) for each different image. The directory is made if it is not there; other files in it
/// stay.
///
/// Equal means that no machine can distinguish them. Files differ from the scenario in this:
/// - A of a `z24` pixel, which no link carries, reads back as 255.
/// - Images that no frame uses are left out.
/// - A viewport is left out if its table is not the one that the host's split makes of it: only the table counts.
///
/// The scenario must have passed check_scenario. Throws InputError for one whose names no file can hold (empty
/// ones and control characters), OutputError if a file cannot be written.
void write_scenario(const Scenario& scenario, const std::filesystem::path& directory);

/// The text of a scenario file in that directory that makes the same scenario from the same image files: every key with
/// its value, copies written out, images by relative paths. The scenario must come from files. Throws InputError for a
/// path that no scenario file can hold.
std::string effective_scenario(const Scenario& scenario, const std::filesystem::path& directory);

}  // namespace metabuffer

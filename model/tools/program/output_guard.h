#pragma once

#include <filesystem>
#include <vector>

#include "scenario/scenario.h"

namespace metabuffer {

/// The files that a run of the scenario is made from: the scenario's own, its images' and those of colour tables.
std::vector<std::filesystem::path> inputs_of(const std::filesystem::path& scenario_file,
                                             const Scenario& scenario);

/// Throws InputError if writing the output would replace one of the inputs, even under another name. `option`: the
/// option that names the output.
void refuse_to_replace(const std::vector<std::filesystem::path>& inputs, const char* option,
                       const std::filesystem::path& output);

}  // namespace metabuffer

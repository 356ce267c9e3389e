#pragma once

#include <filesystem>
#include <string>

#include "scenario/entry.h"
#include "scenario/image_cache.h"
#include "scenario/scenario.h"
#include "scenario/yaml_reader.h"

/// From a scenario's YAML, overrides in place, to the scenario.
namespace metabuffer::input {

/// Fails because of a renderer's key live.
[[noreturn]] void refuse_live(const Entry& live);

/// All except for the images, what follows from them (the tables of viewports), and colour tables. Throws InputError.
Scenario read_settings(const Value& tree, const std::string& default_name);

/// The whole scenario; paths of images and colour tables are relative to `base`. Throws InputError.
Scenario read_scenario(const Value& tree, const std::string& default_name, const std::filesystem::path& base,
                       ImageCache& cache, LiveRenderers live);

}  // namespace metabuffer::input

#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "scenario/scenario.h"

namespace metabuffer {

/// One --set: a dotted path of scenario keys, list entries by their index
/// (`renderers.0.frames.1.viewport.x`), and a YAML value.
struct ScenarioOverride {
    std::string path;
    std::string value;
};

/// Splits "PATH=VALUE". Throws InputError.
ScenarioOverride parse_override(const std::string& text);

/// Reads, checks and resolves a scenario file. Image paths are relative to the file. Overrides are applied before
/// anything is checked. Of the images the headers are read; pixels are read when they are needed, and throw InputError
/// then. Live renderers are refused unless the caller has their applications. Throws InputError.
Scenario load_scenario(const std::filesystem::path& file, const std::vector<ScenarioOverride>& overrides = {},
                       LiveRenderers live = LiveRenderers::kRefused);

/// The same from text; `origin` names it in messages and `base` is what image paths are relative to.
Scenario parse_scenario(const std::string& text, const std::string& origin, const std::filesystem::path& base,
                        const std::vector<ScenarioOverride>& overrides = {});

/// Every key a scenario may have, maps and lists included, in the order of the documentation; a list's
/// entries are written "[]": `renderers[].frames[].viewport.x`.
std::vector<std::string> scenario_key_paths();

/// Reads the images that each run of the scenario needs: those of as many pairs as it shows frames. Throws InputError.
void read_images(const Scenario& scenario);

/// Reads the same images in up to `processes` separate processes before they are needed, while this process goes on. Not
/// if they have so few pixels that starting the processes takes longer.
void read_images_ahead(Scenario& scenario, std::size_t processes);

/// The rules between keys that hold for any scenario, however it was made (also for one built in C++ by a
/// testbench): widths, ready space, tables that fit their control scanline, images of one size. Throws
/// InputError.
void check_scenario(const Scenario& scenario);

}  // namespace metabuffer

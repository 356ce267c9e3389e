#pragma once

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "host/errors.h"
#include "scenario/scenario_loader.h"
#include "support/scratch_directory.h"

namespace metabuffer::test {

/// A black image: with a Z of 0 in an EXR file, without Z in others.
void write_black(const std::filesystem::path& file, int width, int height);

/// The message of the InputError that the call throws; empty if it throws none.
template <typename Call>
std::string input_error_of(Call call) {
    try {
        call();
    } catch (const InputError& error) {
        std::string message = error.what();
        CHECK(message.find('\n') == std::string::npos);
        return message;
    }
    return "";
}

/// A directory with `image.exr`, 16 x 8 pixels: wide enough for a table of one row (34 of 48 bytes), too
/// narrow for two (50).
class ScenarioFixture {
  public:
    static constexpr const char* kDisplays = "displays: {width: 16, height: 8}\n";
    static constexpr const char* kRenderers =
        "renderers:\n"
        "  - frames:\n"
        "      - image: image.exr\n"
        "        viewport: {x: 0, y: 0}\n";

    ScenarioFixture() { write_black(directory_ / "image.exr", 16, 8); }

    const ScratchDirectory& directory() const { return directory_; }

    Scenario parse(const std::string& text, const std::vector<std::string>& overrides = {}) const {
        std::vector<ScenarioOverride> parsed;
        parsed.reserve(overrides.size());
        for (const std::string& one : overrides) parsed.push_back(parse_override(one));
        return parse_scenario(text, "test.yaml", directory_.path(), parsed);
    }
    std::string error(const std::string& text, const std::vector<std::string>& overrides = {}) const {
        return input_error_of([&] { parse(text, overrides); });
    }

    /// The least scenario, with some lines above it.
    static std::string minimal(const std::string& lines_above = "") {
        return lines_above + kDisplays + kRenderers;
    }

  private:
    ScratchDirectory directory_;
};

}  // namespace metabuffer::test

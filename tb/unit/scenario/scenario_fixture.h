#pragma once

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "scenario/scenario_loader.h"
#include "support/refusals.h"
#include "support/scratch_directory.h"

namespace metabuffer::test {

/// A black image: with a Z of 0 in an EXR file, without Z in others.
void write_black(const std::filesystem::path& file, int width, int height);

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

    /// A scenario, overrides of it if there are any, and the line that they are refused with.
    struct Refusal {
        Refusal(std::string scenario, std::string with) : text(std::move(scenario)), line(std::move(with)) {}
        Refusal(std::string scenario, std::vector<std::string> settings, std::string with)
            : text(std::move(scenario)), overrides(std::move(settings)), line(std::move(with)) {}

        std::string text;
        std::vector<std::string> overrides;
        std::string line;
    };
    void check_refusals(const std::vector<Refusal>& refusals) const {
        for (const Refusal& refusal : refusals) {
            INFO(refusal.text);
            check_text(error(refusal.text, refusal.overrides), refusal.line);
        }
    }

    /// The least scenario, with some lines above it.
    static std::string minimal(const std::string& lines_above = "") {
        return lines_above + kDisplays + kRenderers;
    }

  private:
    ScratchDirectory directory_;
};

}  // namespace metabuffer::test

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "support/refusals.h"
#include "support/scratch_directory.h"
#include "tools/exploration/sweep_plan.h"

namespace metabuffer::test {

/// A directory with two scenarios, `case.yaml` and `wide.yaml` (128 bits), whose images are not there: a plan needs
/// none.
class SweepFixture {
  public:
    SweepFixture() {
        const std::string rest =
            "displays: {width: 16, height: 8}\n"
            "renderers:\n"
            "  - frames:\n"
            "      - {image: none.png, z: 0, viewport: {x: 0, y: 0}}\n"
            "      - {image: none.png, z: 0, viewport: {x: 0, y: 0}}\n";
        directory_.write("case.yaml", rest);
        directory_.write("wide.yaml", "bus: {width_bits: 128}\n" + rest);
    }

    const ScratchDirectory& directory() const { return directory_; }

    exploration::SweepDescription parse(const std::string& text) const {
        return exploration::parse_sweep(text, "test.yaml", directory_.path());
    }
    exploration::SweepPlan plan(const std::string& text) const { return exploration::make_plan(parse(text)); }
    /// The error of reading the text and making its plan.
    std::string error(const std::string& text) const {
        return input_error_of([&] { plan(text); });
    }

  private:
    ScratchDirectory directory_;
};

/// All points of the plan.
inline std::vector<exploration::Point> points_of(const exploration::SweepPlan& plan) {
    return {plan.points.begin(), plan.points.end()};
}

/// "bus.width_bits=32 composer.buffer_pixels=64" for each point.
inline std::vector<std::string> point_texts(const exploration::SweepPlan& plan) {
    std::vector<std::string> texts;
    for (const exploration::Point& point : plan.points) {
        std::string text;
        for (const exploration::Setting& setting : point.settings) {
            if (!text.empty()) text += ' ';
            text += setting.key + "=" + setting.value;
        }
        texts.push_back(text);
    }
    return texts;
}

}  // namespace metabuffer::test

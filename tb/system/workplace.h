#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "formats/image.h"
#include "program_run.h"
#include "report/picture_writer.h"

namespace metabuffer::test {

constexpr int kImageWidth = 40;
constexpr int kImageHeight = 20;

/// Two renderers on two displays. The image files are colour only.
constexpr const char* kScenario = R"(name: small
displays: {columns: 2, rows: 1, width: 24, height: 16}
memory: {words_per_cycle: 4}
bus: {width_bits: 256}
renderers:
  - name: left
    frames:
      - {image: a.png, z: 0,
        viewport: {x: 3, y: 2, multiple: 1}}
      - {image: b.png, z: 0,
        viewport: {x: 5, y: 1, multiple: 1}}
  - name: right
    frames:
      - {image: b.png, z: 0,
        viewport: {x: 0, y: 0, multiple: 2}}
)";

/// Overrides with which the scenario starves and bursts are cut short: a bus and buffers that are too small.
inline const std::vector<std::string> kNarrow{"--set", "bus.width_bits=16",
                                              "--set", "composer.buffer_pixels=60",
                                              "--set", "composer.ready_space_pixels=8",
                                              "--set", "memory.page_words=16"};

inline ColourImage gradient(int width, int height, std::uint32_t step) {
    ColourImage image(width, height);
    std::uint32_t colour = step;
    for (std::uint32_t& pixel : image.values) {
        pixel = colour & 0xFFFFFFU;
        colour = colour * 5 + step;
    }
    return image;
}

/// A scratch directory with the scenario and its images.
class Workplace : public ScratchDirectory {
  public:
    Workplace() {
        write("scenario.yaml", kScenario);
        write_png(*this / "a.png", gradient(kImageWidth, kImageHeight, 0x10305));
        write_png(*this / "b.png", gradient(kImageWidth, kImageHeight, 0x52211));
        write_png(*this / "other-size.png", gradient(kImageWidth, kImageHeight + 1, 7));
    }

    /// `metabuffer run scenario.yaml --out out` and the arguments.
    ProgramResult run(const std::vector<std::string>& arguments = {}) const {
        std::vector<std::string> all{"run", "scenario.yaml", "--out", "out"};
        all.insert(all.end(), arguments.begin(), arguments.end());
        return run_program(*this, all);
    }
    nlohmann::json report(const std::string& directory = "out") const {
        return nlohmann::json::parse(text_of(*this / directory / "report.json"));
    }
    bool exists(const std::string& name) const { return std::filesystem::exists(*this / name); }
};

/// What blanks separate.
inline std::vector<std::string> words_of(const std::string& text) {
    std::istringstream stream(text);
    return {std::istream_iterator<std::string>(stream), {}};
}

/// A command's arguments, and what it must be refused with.
struct RefusedCommand {
    std::string arguments;
    std::vector<std::string> words;
};

/// Commands that are refused, each after the same arguments, and that leave nothing.
inline void check_refused_commands(const Workplace& work, const std::string& begin,
                                   const std::vector<RefusedCommand>& commands) {
    const auto visible = [&work] {
        std::vector<std::string> names = work.names();
        const auto hidden = [](const std::string& name) { return name[0] == '.'; };
        names.erase(std::remove_if(names.begin(), names.end(), hidden), names.end());
        return names;
    };
    const std::vector<std::string> before = visible();
    for (const RefusedCommand& command : commands) {
        INFO("metabuffer " << begin << command.arguments);
        check_refused(run_program(work, words_of(begin + command.arguments)), command.words);
        CHECK(visible() == before);
    }
}

inline std::vector<std::string> operator+(std::vector<std::string> a, const std::vector<std::string>& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

}  // namespace metabuffer::test

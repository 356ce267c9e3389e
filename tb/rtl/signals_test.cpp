#include "rtl/signals.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <sstream>
#include <string>
#include <systemc>
#include <vector>

#include "rtl/composer_signals.h"
#include "rtl/display_signals.h"
#include "rtl/enumeration_names.h"
#include "support/lines.h"
#include "support/random_seed.h"
#include "support/scenarios.h"
#include "support/traced_values.h"

namespace metabuffer::test::signals_test {
namespace {

using rtl::BusBeat;

TEST_CASE("signals: a table row crosses the bus in two words and comes out as it went in") {
    const std::uint64_t seed = random_seed(7);
    INFO("seed " << seed);
    Random random(seed);
    for (int i = 0; i < 100; ++i) {
        ViewportRow row;
        row.dcomp = static_cast<std::uint16_t>(random.bits());
        row.sx = static_cast<std::uint16_t>(random.bits());
        row.sy = static_cast<std::uint16_t>(random.bits());
        row.sdx = static_cast<std::uint16_t>(random.bits());
        row.sdy = static_cast<std::uint16_t>(random.bits());
        row.dx = static_cast<std::int16_t>(random.bits());
        row.dy = static_cast<std::int16_t>(random.bits());
        row.dmultiple = static_cast<std::uint16_t>(random.bits());
        const auto frame = static_cast<std::uint8_t>(255 - i);
        const BusBeat beat =
            BusBeat::table_row(frame, 1000U + static_cast<std::uint32_t>(i), row, i % 2 == 0);
        CHECK(beat.kind == BusBeat::Kind::kTableRow);
        CHECK(beat.count == 2);
        CHECK(beat.destination == row.dcomp);
        CHECK(beat.last == (i % 2 == 0));
        CHECK(beat.frame == frame);
        CHECK(beat.first == 1000U + static_cast<std::uint32_t>(i));
        CHECK(beat.row() == row);
    }
}

TEST_CASE("signals: a frame's start carries no word and says whether a table follows") {
    for (const bool last : {false, true}) {
        const BusBeat beat = BusBeat::frame_start(200, last);
        CHECK(beat.kind == BusBeat::Kind::kFrameStart);
        CHECK(beat.count == 0);
        CHECK(beat.frame == 200);
        CHECK(beat.last == last);
    }
}

TEST_CASE("signals: a beat has a word for each of its pixels, and two at least for a row of the table") {
    CHECK(BusBeat::lanes(1) == 2);
    for (int pixels = 2; pixels <= rtl::kMaximumBeatPixels; ++pixels) CHECK(BusBeat::lanes(pixels) == pixels);
}

template <typename Value>
std::string text_of(const Value& value) {
    std::ostringstream stream;
    stream << value;
    return stream.str();
}

TEST_CASE("signals: the words of a beat are traced by their numbers, as many as are asked for") {
    const std::array<std::uint64_t, rtl::kMaximumBeatPixels> words{5, 6, 7, 8};
    const auto traced =
        traced_by([&words](sc_core::sc_trace_file* file) { rtl::trace_lanes(file, words, 3, "word"); });
    CHECK(traced == std::vector<std::string>{"word_0[64]=5", "word_1[64]=6", "word_2[64]=7"});
}

TEST_CASE(
    "signals: what a composer's parts say to each other is traced, a number in as many bits as it has") {
    const rtl::HeadSegment head{true, Segment(segment_row({3, 2}, {-1, 4}, 5), 20, 20)};
    const rtl::SegmentProgress progress{true, 5, 70};
    RasterStep step;
    step.pixel = 9;
    step.across = -3;
    step.beside = -1;
    step.weight_x = 64;
    step.weight_y = 127;
    step.last = step.replayed = true;
    const rtl::PixelUse use{true, Segment::kNoPixel};
    const auto traced = traced_by([&](sc_core::sc_trace_file* file) {
        sc_trace(file, head, "head");
        sc_trace(file, progress, "progress", 6);
        sc_trace(file, step, "step", 6);
        sc_trace(file, use, "use", 6);
    });
    CHECK(traced == std::vector<std::string>{"head.shown[1]=1", "head.width[16]=3", "head.height[16]=2",
                                             "head.x[16]=65535", "head.y[16]=4", "head.multiple[8]=5",
                                             "progress.abandoned[1]=1", "progress.arrived[6]=5",
                                             "step.last[1]=1", "step.covered[1]=0", "step.replayed[1]=1",
                                             "step.pixel[6]=9", "step.beside[2]=3", "step.across[17]=131069",
                                             "step.weight_x[8]=64", "step.weight_y[8]=127",
                                             "use.ends_frame[1]=1", "use.last_use[6]=63"});
}

TEST_CASE("signals: what an output framebuffer's parts say to each other is traced") {
    const rtl::DisplayWrite write{true, 5, 0xABCDEF};
    const rtl::DisplayRead read{false, 6};
    const auto traced = traced_by([&](sc_core::sc_trace_file* file) {
        sc_trace(file, write, "write", 4);
        sc_trace(file, read, "read", 3);
    });
    CHECK(traced == std::vector<std::string>{"read.bank[1]=0", "read.address[3]=6", "write.bank[1]=1",
                                             "write.address[4]=5", "write.colour[24]=11259375"});
}

TEST_CASE(
    "signals: every enumeration has its names in a translate file for GTKWave, and no file is left over") {
    const std::filesystem::path folder =
        std::filesystem::path(METABUFFER_SOURCE_DIRECTORY) / "waves/translate";
    for (const rtl::EnumerationNames& enumeration : rtl::enumeration_names()) {
        std::vector<std::string> wanted;
        for (const std::string& word : enumeration.words) {
            const std::size_t n = wanted.size();
            wanted.push_back((enumeration.values.empty() ? std::to_string(n) : enumeration.values.at(n)) +
                             " " + word);
        }
        INFO(enumeration.file);
        CHECK(lines_of_file(folder / enumeration.file) == wanted);
    }
    using Iterator = std::filesystem::directory_iterator;
    CHECK(static_cast<std::size_t>(std::distance(Iterator(folder), Iterator())) ==
          rtl::enumeration_names().size());
}

TEST_CASE("signals: the save files show enumerations by their names") {
    int shown = 0;
    for (const auto& entry :
         std::filesystem::directory_iterator(std::filesystem::path(METABUFFER_SOURCE_DIRECTORY) / "waves")) {
        if (entry.path().extension() != ".gtkw") continue;
        std::string before;
        for (const std::string& line : lines_of_file(entry.path())) {
            for (const rtl::EnumerationNames& enumeration : rtl::enumeration_names()) {
                if (line.find("." + enumeration.signal + "[") == std::string::npos) continue;
                INFO(entry.path().filename().string() << ": " << line);
                CHECK(before == "^1 waves/translate/" + enumeration.file);
                ++shown;
            }
            before = line;
        }
    }
    CHECK(shown > 0);
}

TEST_CASE("signals: memory commands are equal if they say the same of the words that they name") {
    using rtl::MemoryCommand;
    MemoryCommand read;
    read.kind = MemoryCommand::Kind::kRead;
    read.row = 5;
    read.count = 2;
    read.columns[0] = 8;
    read.columns[1] = 9;
    read.columns[2] = 10;  // beyond the count
    MemoryCommand same = read;
    same.columns[2] = 0;
    CHECK(same == read);
    for (const std::size_t column : {0U, 1U}) {
        MemoryCommand other = read;
        ++other.columns.at(column);
        CHECK_FALSE(other == read);
    }
}

/// A value differs from those that differ from it in one member, and each of them from the others.
template <typename Value>
void check_all_differ(const std::vector<Value>& values) {
    for (std::size_t i = 0; i < values.size(); ++i) {
        for (std::size_t j = 0; j < values.size(); ++j) {
            INFO(values[i] << " and " << values[j]);
            CHECK((values[i] == values[j]) == (i == j));
        }
    }
}

TEST_CASE("signals: segments on a raster are equal if their rows are, and if both or neither are shown") {
    using rtl::HeadSegment;
    const auto shown = [](const ViewportRow& row) { return HeadSegment{true, Segment(row, 20, 20)}; };
    const HeadSegment none;
    const HeadSegment segment = shown(segment_row({3, 2}, {4, 5}, 2));
    HeadSegment hidden = segment;
    hidden.shown = false;
    check_all_differ<HeadSegment>(
        {none, segment, hidden, shown(segment_row({2, 2}, {4, 5}, 2)), shown(segment_row({3, 3}, {4, 5}, 2)),
         shown(segment_row({3, 2}, {3, 5}, 2)), shown(segment_row({3, 2}, {4, 6}, 2)),
         shown(segment_row({3, 2}, {4, 5}, 3))});
    CHECK(text_of(none) == "no segment");
    CHECK(text_of(hidden) == "no segment");
    CHECK(text_of(segment) == "3x2 pixels at 4,5, each 2x2");
}

TEST_CASE("signals: what a composer's parts say to each other is equal if every member is, and is printed") {
    using rtl::PixelUse;
    using rtl::SegmentProgress;
    check_all_differ<SegmentProgress>({{}, {true, 0, 0}, {false, 1, 0}, {false, 0, 1}});
    CHECK(text_of(SegmentProgress{false, 7, 12}) == "7 pixels from address 12 on");
    CHECK(text_of(SegmentProgress{true, 7, 12}) == "7 pixels from address 12 on, abandoned");
    CHECK(SegmentProgress{false, 7, 0}.has_arrived(6));
    CHECK_FALSE(SegmentProgress{false, 7, 0}.has_arrived(7));
    check_all_differ<RasterStep>({{},
                                  {1},
                                  {0, 1},
                                  {0, 0, 1},
                                  {0, 0, 0, 1},
                                  {0, 0, 0, 0, 1},
                                  {0, 0, 0, 0, 0, true},
                                  {0, 0, 0, 0, 0, false, true},
                                  {0, 0, 0, 0, 0, false, false, true}});
    CHECK(text_of(RasterStep{}) == "not covered");
    CHECK(text_of(RasterStep{9, -3, 1, 64, 32, true, true, true}) ==
          "last position, pixel 9 again, beside 1 weighs 64, across -3 weighs 32");
    check_all_differ<PixelUse>({{}, {true, Segment::kNoPixel}, {false, 0}, {false, 1}, {true, 1}});
    CHECK(text_of(PixelUse{}) == "no pixel's last use");
    CHECK(text_of(PixelUse{true, 4}) == "last use of pixel 4, the frame's end");
    CHECK_FALSE(PixelUse{}.any());
    CHECK(PixelUse{true, Segment::kNoPixel}.any());
    CHECK(PixelUse{false, 0}.any());
}

TEST_CASE(
    "signals: a raster position needs up to four pixels, and the newest of them is that of its last row") {
    const auto pixels_of = [](const RasterStep& step) {
        const BlendWindow<std::int64_t> window = step.window();
        return std::vector<std::int64_t>{window.own, window.beside, window.across, window.diagonal};
    };
    using Pixels = std::vector<std::int64_t>;
    CHECK(pixels_of({9}) == Pixels{9, -1, -1, -1});
    CHECK(pixels_of({9, 0, -1}) == Pixels{9, 8, -1, -1});
    CHECK(pixels_of({9, 4, 0}) == Pixels{9, -1, 13, -1});
    CHECK(pixels_of({9, -4, 1}) == Pixels{9, 10, 5, 6});
    for (const int across : {-4, 0, 4}) {
        for (const int beside : {-1, 0, 1}) {
            const RasterStep step{9, across, beside};
            const Pixels pixels = pixels_of(step);
            CHECK(step.newest() == *std::max_element(pixels.begin(), pixels.end()));
        }
    }
}

TEST_CASE(
    "signals: what an output framebuffer's parts say to each other is equal if every member is, and is "
    "printed") {
    using rtl::DisplayRead;
    using rtl::DisplayWrite;
    check_all_differ<DisplayWrite>({{}, {true, 0, 0}, {false, 1, 0}, {false, 0, 1}});
    check_all_differ<DisplayRead>({{}, {true, 0}, {false, 1}});
    std::ostringstream stream;
    stream << DisplayWrite{true, 17, 0xABCDEF} << ", " << 17;  // the stream is left as it was
    CHECK(stream.str() == "bank 1 address 17 colour 0xabcdef, 17");
    CHECK(text_of(DisplayRead{false, 17}) == "bank 0 address 17");
}

TEST_CASE("signals: the bits of pixels and addresses follow from the scenario") {
    Scenario scenario = small_scenario(6, 4);
    scenario.displays.supersample = 2;
    scenario.composer.buffer_pixels = 33;
    // A smoothed segment on 12x8 raster pixels has up to 14x10; one bit more is for none.
    CHECK(rtl::segment_pixel_bits(scenario) == 8 + 1);
}

}  // namespace
}  // namespace metabuffer::test::signals_test

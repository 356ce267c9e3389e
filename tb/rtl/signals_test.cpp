#include "rtl/signals.h"

#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <sstream>
#include <string>
#include <systemc>
#include <utility>
#include <vector>

#include "rtl/composer_signals.h"
#include "rtl/display_signals.h"
#include "rtl/enumeration_names.h"
#include "support/lines.h"
#include "support/scenarios.h"
#include "support/traced_values.h"

namespace metabuffer::test::signals_test {
namespace {

using rtl::BusBeat;
using rtl::DisplayRead;
using rtl::DisplayWrite;
using rtl::HeadSegment;
using rtl::MemoryCommand;
using rtl::MemoryData;
using rtl::PixelUse;
using rtl::SegmentProgress;

TEST_CASE("signals: a beat is of its kind and frame, and a table's row leaves its words as it came") {
    const ViewportRow row{65535, 1, 32768, 2, 43690, -32768, -1, 255};
    for (const bool last : {false, true}) {
        const BusBeat row_beat = BusBeat::table_row(65536, 1000, row, last);
        const BusBeat start = BusBeat::frame_start(65536, last);
        CHECK(row_beat.kind == BusBeat::Kind::kTableRow);
        CHECK(start.kind == BusBeat::Kind::kFrameStart);
        CHECK(row_beat.count == 2);
        CHECK(start.count == 0);
        CHECK(row_beat.first == 1000);
        CHECK(row_beat.destination == 65535);
        CHECK(row_beat.row() == row);
        for (const BusBeat& beat : {row_beat, start}) CHECK((beat.frame == 65536 && beat.last == last));
    }
    // It has a word for each of its pixels, and two at least for a row of the table.
    CHECK(BusBeat::lanes(1) == 2);
    for (int pixels = 2; pixels <= rtl::kMaximumBeatPixels; ++pixels) CHECK(BusBeat::lanes(pixels) == pixels);
}

HeadSegment shown(const ViewportRow& row) { return {true, Segment(row, 20, 20)}; }

TEST_CASE("signals: a structure is traced by its members, each in as many bits as it has") {
    const std::array<std::uint64_t, rtl::kMaximumBeatPixels> words{5, 6, 7, 8};
    const HeadSegment head = shown(segment_row({3, 2}, {-1, 4}, 5));
    const SegmentProgress progress{true, 5, 70};
    const RasterStep step{9, -3, -1, 64, 127, true, false, true};
    const PixelUse use{true, Segment::kNoPixel};
    const DisplayWrite write{true, 5, 0xABCDEF};
    const DisplayRead read{false, 6};
    const auto traced = traced_by([&](sc_core::sc_trace_file* file) {
        rtl::trace_lanes(file, words, 3, "word");
        sc_trace(file, head, "head");
        sc_trace(file, progress, "progress", 6);
        sc_trace(file, step, "step", 6);
        sc_trace(file, use, "use", 6);
        sc_trace(file, write, "write", 4);
        sc_trace(file, read, "read", 3);
    });
    CHECK(traced == std::vector<std::string>{"word_0[64]=5",           "word_1[64]=6",
                                             "word_2[64]=7",           "head.shown[1]=1",
                                             "head.width[16]=3",       "head.height[16]=2",
                                             "head.x[16]=65535",       "head.y[16]=4",
                                             "head.multiple[8]=5",     "progress.abandoned[1]=1",
                                             "progress.arrived[6]=5",  "read.bank[1]=0",
                                             "read.address[3]=6",      "step.last[1]=1",
                                             "step.covered[1]=0",      "step.replayed[1]=1",
                                             "step.pixel[6]=9",        "step.beside[2]=3",
                                             "step.across[17]=131069", "step.weight_x[8]=64",
                                             "step.weight_y[8]=127",   "use.ends_frame[1]=1",
                                             "use.last_use[6]=63",     "write.bank[1]=1",
                                             "write.address[4]=5",     "write.colour[24]=11259375"});
    // A smoothed segment on 12x8 raster pixels has up to 14x10; one bit more is for none.
    Scenario scenario = small_scenario(6, 4);
    scenario.displays.supersample = 2;
    CHECK(rtl::segment_pixel_bits(scenario) == 8 + 1);
}

/// A value equals none that differs from it in a member. Each prints as its text and leaves the stream as it was.
template <typename Value>
void check_values(const std::vector<std::pair<Value, std::string>>& values) {
    for (const auto& [value, text] : values) {
        for (const auto& other : values) {
            INFO(text << " and " << other.second);
            CHECK((value == other.first) == (&text == &other.second));
        }
        std::ostringstream stream;
        stream << value << ' ' << 17;
        CHECK(stream.str() == text + " 17");
    }
}

TEST_CASE("signals: structures are equal if every member is that means something, and are printed") {
    HeadSegment hidden = shown(segment_row({3, 2}, {4, 5}, 2));
    hidden.shown = false;
    check_values<HeadSegment>(
        {{{}, "{ }"},
         {hidden, "{ width=3 height=2 x=4 y=5 multiple=2 }"},
         {shown(hidden.segment.row()), "{ shown=1 width=3 height=2 x=4 y=5 multiple=2 }"},
         {shown(segment_row({2, 2}, {4, 5}, 2)), "{ shown=1 width=2 height=2 x=4 y=5 multiple=2 }"},
         {shown(segment_row({3, 3}, {4, 5}, 2)), "{ shown=1 width=3 height=3 x=4 y=5 multiple=2 }"},
         {shown(segment_row({3, 2}, {-3, 5}, 2)), "{ shown=1 width=3 height=2 x=-3 y=5 multiple=2 }"},
         {shown(segment_row({3, 2}, {4, 6}, 2)), "{ shown=1 width=3 height=2 x=4 y=6 multiple=2 }"},
         {shown(segment_row({3, 2}, {4, 5}, 3)), "{ shown=1 width=3 height=2 x=4 y=5 multiple=3 }"}});
    check_values<SegmentProgress>({{{}, "{ }"},
                                   {{true, 7, 12}, "{ abandoned=1 arrived=7 base_address=12 }"},
                                   {{false, 7, 12}, "{ arrived=7 base_address=12 }"},
                                   {{false, 8, 12}, "{ arrived=8 base_address=12 }"},
                                   {{false, 7, 13}, "{ arrived=7 base_address=13 }"}});
    check_values<RasterStep>(
        {{{}, "{ }"},
         {{1}, "{ pixel=1 }"},
         {{0, 1}, "{ across=1 }"},
         {{0, 0, 1}, "{ beside=1 }"},
         {{0, 0, 0, 1}, "{ weight_x=1 }"},
         {{0, 0, 0, 0, 1}, "{ weight_y=1 }"},
         {{0, 0, 0, 0, 0, true}, "{ last=1 }"},
         {{0, 0, 0, 0, 0, false, true}, "{ covered=1 }"},
         {{0, 0, 0, 0, 0, false, false, true}, "{ replayed=1 }"},
         {{9, -3, 1, 64, 32, true, true, true},
          "{ last=1 covered=1 replayed=1 pixel=9 beside=1 across=-3 weight_x=64 weight_y=32 }"}});
    check_values<PixelUse>({{{}, "{ last_use=-1 }"},
                            {{true, Segment::kNoPixel}, "{ ends_frame=1 last_use=-1 }"},
                            {{false, 0}, "{ }"},
                            {{true, 1}, "{ ends_frame=1 last_use=1 }"}});
    check_values<DisplayWrite>({{{}, "{ }"},
                                {{true, 0, 0}, "{ bank=1 }"},
                                {{false, 17, 0}, "{ address=17 }"},
                                {{false, 0, 0xAB}, "{ colour=171 }"}});
    check_values<DisplayRead>({{{}, "{ }"}, {{true, 0}, "{ bank=1 }"}, {{false, 17}, "{ address=17 }"}});
    // Of an array its first elements count, and are printed.
    check_values<MemoryData>({{{}, "{ }"},
                              {{2, {8, 9, 10}}, "{ count=2 word_0=8 word_1=9 }"},
                              {{2, {8, 8, 10}}, "{ count=2 word_0=8 word_1=8 }"},
                              {{3, {8, 9, 10}}, "{ count=3 word_0=8 word_1=9 word_2=10 }"}});
    MemoryCommand read;
    read.kind = MemoryCommand::Kind::kRead;
    read.row = 5;
    read.count = 2;
    read.columns = {8, 9, 10};
    MemoryCommand first = read, second = read, beyond_the_count = read;
    first.columns = {7, 9, 10};
    second.columns = {8, 8, 10};
    beyond_the_count.columns = {8, 9, 9};
    check_values<MemoryCommand>({{read, "read 2 from word 8 of page 5"},
                                 {first, "read 2 from word 7 of page 5"},
                                 {second, "read 2 from word 8 of page 5"}});
    CHECK(beyond_the_count == read);
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

}  // namespace
}  // namespace metabuffer::test::signals_test

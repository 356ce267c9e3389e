#include "rtl/signals.h"

#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <systemc>
#include <vector>

#include "rtl/enumeration_names.h"
#include "support/random_seed.h"
#include "support/scenarios.h"
#include "support/scratch_directory.h"

namespace metabuffer::test {
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

std::vector<std::string> lines_of(const std::filesystem::path& file) {
    std::ifstream stream(file);
    std::vector<std::string> lines;
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
}

TEST_CASE("signals: the words of a beat are traced by their numbers, as many as are asked for") {
    const ScratchDirectory scratch;
    const std::array<std::uint64_t, rtl::kMaximumBeatPixels> words{5, 6, 7, 8};
    sc_core::sc_trace_file* const file = sc_core::sc_create_vcd_trace_file((scratch / "lanes").c_str());
    rtl::trace_lanes(file, words, 3, "word");
    sc_core::sc_start(1, sc_core::SC_NS);
    sc_core::sc_close_vcd_trace_file(file);
    std::map<std::string, std::string> names;  // by identifier
    std::map<std::string, std::uint64_t> values;
    for (const std::string& line : lines_of(scratch / "lanes.vcd")) {
        std::istringstream stream(line);
        std::string keyword, type, width, identifier, name;
        stream >> keyword;
        if (keyword == "$var") {
            stream >> type >> width >> identifier >> name;
            names[identifier] = name;
        } else if (keyword[0] == 'b') {
            stream >> identifier;
            values[names[identifier]] = std::stoull(keyword.substr(1), nullptr, 2);
        }
    }
    CHECK(values == std::map<std::string, std::uint64_t>{{"word_0", 5}, {"word_1", 6}, {"word_2", 7}});
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
        CHECK(lines_of(folder / enumeration.file) == wanted);
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
        for (const std::string& line : lines_of(entry.path())) {
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

}  // namespace
}  // namespace metabuffer::test

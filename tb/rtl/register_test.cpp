#include "rtl/register.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>
#include <systemc>
#include <vector>

#include "support/scratch_directory.h"

namespace metabuffer::test {
namespace {

using rtl::Register;
using rtl::RegisterLine;
using rtl::RegisterSet;

TEST_CASE("register: as many bits as a number needs") {
    CHECK(rtl::bits_for(0) == 1);
    CHECK(rtl::bits_for(1) == 1);
    CHECK(rtl::bits_for(2) == 2);
    CHECK(rtl::bits_for(255) == 8);
    CHECK(rtl::bits_for(256) == 9);
    CHECK(rtl::bits_for((std::int64_t{1} << 62) - 1) == 62);
    CHECK(rtl::bits_for(std::int64_t{1} << 62) == 63);
}

TEST_CASE("register: a reset of the set leaves in each register what power-up leaves") {
    RegisterSet set;
    Register<int> count(set, "count", 8, 7);
    Register<bool> flag(set, "flag");
    RegisterLine<int> line(set, "line", 2, 8);
    CHECK(count == 7);
    CHECK_FALSE(flag);
    count = 9;
    flag = true;
    line.fill(5);
    set.reset();
    CHECK(count == 7);
    CHECK_FALSE(flag);
    CHECK(line.holds(0));
}

/// A part of a block with three registers, one of which may be negative, and a count that a reset leaves.
struct Part {
    int level = 3;
    bool full = false;
    int offset = -1;
    int counted = 0;
    void reset() { *this = Part{3, false, -1, counted}; }
    template <typename See>
    void visit_state(const See& see) const {
        see("level", level, 9);
        see("full", full, 1);
        see("offset", offset, 7, -7);
    }
};

TEST_CASE(
    "register: the state of a part is in the waveform, each with its width, and its reset is the part's "
    "own") {
    const ScratchDirectory scratch;
    RegisterSet set;
    Register<Part> part(set, "part", 1, Part{});
    Register<Part> unnamed(set, "");
    part->level = 5;
    part->counted = 4;
    set.reset();
    CHECK(part->level == 3);
    CHECK(part->counted == 4);
    part->level = 9;
    part->full = true;
    part->offset = -7;
    sc_core::sc_trace_file* const file = sc_core::sc_create_vcd_trace_file((scratch / "part").c_str());
    set.trace(file, "block.");
    sc_core::sc_start(1, sc_core::SC_NS);
    sc_core::sc_close_vcd_trace_file(file);
    std::ifstream in(scratch / "part.vcd");
    const std::string dump(std::istreambuf_iterator<char>(in), {});
    CHECK(std::regex_search(dump, std::regex(R"(\$var wire +4 +\S+ +part_level \[3:0\])")));
    CHECK(std::regex_search(dump, std::regex(R"(\$var wire +1 +\S+ +part_full )")));
    CHECK(std::regex_search(dump, std::regex(R"(\$var wire +4 +\S+ +part_offset \[3:0\])")));
    CHECK(std::regex_search(dump, std::regex(R"(\$var wire +4 +\S+ +level \[3:0\])")));
    CHECK(dump.find("b1001 ") != std::string::npos);  // 9, and -7 in four bits
    CHECK(dump.find("bx") == std::string::npos);
}

TEST_CASE("register: what comes into a line leaves it as many edges later as it has stages") {
    for (int stages = 0; stages <= 4; ++stages) {
        INFO(stages << " stages");
        RegisterSet set;
        RegisterLine<int> line(set, "line", stages, 8);
        CHECK(line.empty() == (stages == 0));
        std::vector<int> left;
        for (int edge = 1; edge <= 8; ++edge) {
            if (stages > 0) CHECK(line.last() == (edge > stages ? edge - stages : 0));
            left.push_back(line.shift(edge));
        }
        for (int edge = 1; edge <= 8; ++edge) {
            CHECK(left[static_cast<std::size_t>(edge - 1)] == (edge > stages ? edge - stages : 0));
        }
    }
}

TEST_CASE("register: a line holds a value if every stage has it") {
    RegisterSet set;
    RegisterLine<int> line(set, "line", 3, 8);
    CHECK(line.holds(0));
    line.shift(4);
    CHECK_FALSE(line.holds(0));
    line.shift(4);
    CHECK_FALSE(line.holds(4));
    line.shift(4);
    CHECK(line.holds(4));
    line.fill(6);
    CHECK(line.holds(6));
    CHECK(line.shift(0) == 6);
    CHECK(RegisterLine<int>(set, "none", 0, 8).holds(1));
}

}  // namespace
}  // namespace metabuffer::test

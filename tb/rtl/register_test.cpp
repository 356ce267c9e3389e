#include "rtl/register.h"

#include <catch2/catch.hpp>
#include <string>
#include <systemc>
#include <vector>

#include "support/traced_values.h"

namespace metabuffer::test::register_test {
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
    RegisterSet set;
    Register<Part> part(set, "part", 1, Part{});
    Register<Part> unnamed(set, "");
    part.change().level = 5;
    part.change().counted = 4;
    set.reset();
    CHECK(part->level == 3);
    CHECK(part->counted == 4);
    part.change().level = 9;
    part.change().full = true;
    part.change().offset = -7;
    const auto traced = traced_by([&set](sc_core::sc_trace_file* file) { set.trace(file, "block."); });
    // -7 in four bits is 9, and -1 is 15.
    CHECK(traced == std::vector<std::string>{"block.part_level[4]=9", "block.part_full[1]=1",
                                             "block.part_offset[4]=9", "block.level[4]=3", "block.full[1]=0",
                                             "block.offset[4]=15"});
}

TEST_CASE("register: a set knows at which edges one of its registers, or of its parts', gets another value") {
    RegisterSet set, part_of_set(set);
    Register<int> count(set, "count", 8, 7);
    Register<bool> flag(part_of_set, "flag");
    Register<Part> memory(set, "memory");
    const auto changes = [&set](const auto& edge) {
        edge();
        return set.end_edge();
    };
    CHECK_FALSE(changes([] {}));
    CHECK_FALSE(changes([&] { count = 7; }));
    CHECK(changes([&] { ++count; }));
    CHECK_FALSE(changes([] {}));
    CHECK(changes([&] { flag = true; }));
    CHECK_FALSE(changes([&] { flag = true; }));
    CHECK_FALSE(changes([&] { CHECK(memory->level == 3); }));
    CHECK(changes([&] { memory.change().level = 5; }));
    CHECK(changes([&] { set.note_change(); }));
    CHECK(changes([&] { part_of_set.note_change(); }));
    CHECK(changes([&] { set.reset(); }));
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
}  // namespace metabuffer::test::register_test

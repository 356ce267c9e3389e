#include "scenario/names.h"

#include <catch2/catch.hpp>
#include <set>

namespace metabuffer {
namespace {

template <typename Enum>
void check_round_trip(Enum last) {
    const auto count = static_cast<std::size_t>(last) + 1;
    REQUIRE(EnumNames<Enum>::kTable.size() == count);
    std::set<std::string> names;
    for (std::size_t i = 0; i < count; ++i) {
        const auto value = static_cast<Enum>(i);
        const std::string name = to_string(value);
        INFO(name);
        CHECK(name != "?");
        CHECK(from_name<Enum>(name) == value);
        names.insert(name);
    }
    CHECK(names.size() == count);
    CHECK(enum_names<Enum>().size() == count);
    CHECK_FALSE(from_name<Enum>("").has_value());
    CHECK_FALSE(from_name<Enum>("?").has_value());
    CHECK(std::string(to_string(static_cast<Enum>(255))) == "?");
}

}  // namespace

TEST_CASE("names: every enumerator has a name of its own, as the scenario files write it") {
    check_round_trip(kCompositionTable.back().value);
    check_round_trip(kDepthFormatTable.back().value);
    check_round_trip(kArbitrationTable.back().value);
    check_round_trip(StarvationMode::kStall);
    check_round_trip(Pacing::kFreeRunning);
    check_round_trip(FaultKind::kTmdsNoise);
    check_round_trip(LinkLayer::kTmds);
    check_round_trip(TmdsChannel::kRed);
    check_round_trip(FrameKind::kDepth);
    check_round_trip(LostBeats::kAny);
    CHECK(std::string(to_string(Composition::kZAlphaKey)) == "z-alpha-key");
    CHECK(std::string(to_string(Arbitration::kSlotAllocation)) == "slot-allocation");
    CHECK(std::string(to_string(Pacing::kFreeRunning)) == "free-running");
    CHECK(std::string(to_string(FaultKind::kShortLine)) == "short_line");
    CHECK(std::string(to_string(FrameKind::kColour)) == "colour");
}

}  // namespace metabuffer

#include "rtl/enumeration_names.h"

#include <bitset>
#include <cstddef>
#include <stdexcept>

#include "datapath/link/pair_follower.h"
#include "datapath/link/pair_keeper.h"
#include "report/report.h"
#include "rtl/bus_port.h"
#include "rtl/dvi_source.h"
#include "rtl/signals.h"

namespace metabuffer::rtl {
namespace {

/// The words; there must be one for each value up to the enumeration's last.
template <typename Enum, std::size_t kCount>
std::vector<std::string> words(Enum last, const char* const (&list)[kCount]) {
    if (static_cast<std::size_t>(last) + 1 != kCount) {
        throw std::logic_error("an enumeration has other values than names");
    }
    return {list, list + kCount};
}

std::vector<std::string> reject_causes() {
    std::vector<std::string> causes;
    causes.reserve(kRejectCauseCount);
    for (int cause = 0; cause < kRejectCauseCount; ++cause) {
        causes.emplace_back(reject_cause_key(static_cast<RejectCause>(cause)));
    }
    return causes;
}

std::vector<std::string> control_characters() {
    std::vector<std::string> characters;
    characters.reserve(kTmdsControl.size());
    for (const TmdsCharacter character : kTmdsControl) {
        characters.push_back(std::bitset<kTmdsCharacterBits>(character).to_string());
    }
    return characters;
}

}  // namespace

const std::vector<EnumerationNames>& enumeration_names() {
    static const std::vector<EnumerationNames> names{
        {"BUS.kind", "bus_kind.txt",
         words(BusBeat::Kind::kPixels, {"none", "frame start", "table row", "pixels"})},
        {"command.kind", "memory_command.txt",
         words(MemoryCommand::Kind::kWrite,
               {"none", "activate", "read", "precharge", "precharge all", "refresh", "write"})},
        {"answer.kind", "memory_answer.txt",
         words(MemoryAnswer::Kind::kWrite, {"none", "read", "open", "refresh", "write"})},
        {"bus_port.state", "bus_port_state.txt",
         words(BusPort::State::kDone, {"request", "wait for pair", "table", "send", "done"})},
        {"dvi_source_1.state", "dvi_source_state.txt",
         words(DviSource::State::kFrame, {"first sync", "idle", "silence", "frame"})},
        {"PIXEL.kind", "frame_kind.txt", words(FrameKind::kDepth, {"colour", "depth"})},
        {"pair_expect", "pair_expect.txt",
         words(PairFollower::Expect::kDepth, {"any colour", "colour", "depth"})},
        {"banks_back", "back_bank.txt", words(PairKeeper::Back::kWhole, {"free", "filling", "whole"})},
        {"EVENT.cause", "reject_cause.txt", reject_causes()},
        {"TMDS.BLUE", "tmds_control.txt", {"blank", "HSYNC", "VSYNC", "HSYNC VSYNC"}, control_characters()},
    };
    return names;
}

}  // namespace metabuffer::rtl

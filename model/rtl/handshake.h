#pragma once

#include <cstdint>

#include "scenario/names.h"

namespace metabuffer::rtl {

/// The handshake wires that a fault can hold: STALL high, the others low.
enum class Handshake : std::uint8_t {
    kBusready,
    kTableready,
    kPipeready,
    kPairRequest,
    kStall,
    kFramedone,
    kSwaplock,
    kSwapskip  ///< with SWAPLOCK, by one module
};

}  // namespace metabuffer::rtl

namespace metabuffer {

template <>
struct EnumNames<rtl::Handshake> {
    static constexpr const char* kWhat = "a handshake";
    static constexpr auto kTable = name_table<rtl::Handshake>({{rtl::Handshake::kBusready, "BUSREADY"},
                                                               {rtl::Handshake::kTableready, "TABLEREADY"},
                                                               {rtl::Handshake::kPipeready, "PIPEREADY"},
                                                               {rtl::Handshake::kPairRequest, "PAIR_REQUEST"},
                                                               {rtl::Handshake::kStall, "STALL"},
                                                               {rtl::Handshake::kFramedone, "FRAMEDONE"},
                                                               {rtl::Handshake::kSwaplock, "SWAPLOCK"},
                                                               {rtl::Handshake::kSwapskip, "SWAPSKIP"}});
};

}  // namespace metabuffer

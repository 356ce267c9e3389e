#include "rtl/signals.h"

namespace metabuffer::rtl {
namespace {

constexpr int kFieldBits = 16;

std::uint64_t pack(std::uint16_t a, std::uint16_t b, std::uint16_t c, std::uint16_t d) {
    return std::uint64_t{a} | (std::uint64_t{b} << kFieldBits) | (std::uint64_t{c} << (2 * kFieldBits)) |
           (std::uint64_t{d} << (3 * kFieldBits));
}

std::uint16_t field(std::uint64_t word, int position) {
    return static_cast<std::uint16_t>(word >> (position * kFieldBits));
}

}  // namespace

BusBeat BusBeat::frame_start(std::uint32_t frame, bool last) {
    BusBeat beat;
    beat.kind = Kind::kFrameStart;
    beat.last = last;
    beat.frame = frame;
    return beat;
}

BusBeat BusBeat::table_row(std::uint32_t frame, std::uint32_t index, const ViewportRow& row, bool last) {
    BusBeat beat;
    beat.kind = Kind::kTableRow;
    beat.last = last;
    beat.frame = frame;
    beat.first = index;
    beat.count = 2;
    beat.destination = row.dcomp;
    beat.words[0] = pack(row.dcomp, row.sx, row.sy, row.sdx);
    beat.words[1] =
        pack(row.sdy, static_cast<std::uint16_t>(row.dx), static_cast<std::uint16_t>(row.dy), row.dmultiple);
    return beat;
}

ViewportRow BusBeat::row() const {
    ViewportRow row;
    row.dcomp = field(words[0], 0);
    row.sx = field(words[0], 1);
    row.sy = field(words[0], 2);
    row.sdx = field(words[0], 3);
    row.sdy = field(words[1], 0);
    row.dx = static_cast<std::int16_t>(field(words[1], 1));
    row.dy = static_cast<std::int16_t>(field(words[1], 2));
    row.dmultiple = field(words[1], 3);
    return row;
}

std::ostream& operator<<(std::ostream& out, const MemoryCommand& value) {
    switch (value.kind) {
        case MemoryCommand::Kind::kNone:
            return out << "none";
        case MemoryCommand::Kind::kActivate:
            return out << "activate page " << value.row << " in bank " << int{value.bank};
        case MemoryCommand::Kind::kRead:
            return out << "read " << int{value.count} << " from word " << value.columns[0] << " of page "
                       << value.row;
        case MemoryCommand::Kind::kPrecharge:
            return out << "precharge bank " << int{value.bank};
        case MemoryCommand::Kind::kPrechargeAll:
            return out << "precharge all";
        case MemoryCommand::Kind::kRefresh:
            return out << "refresh";
        case MemoryCommand::Kind::kWrite:
            return out << "write " << int{value.count} << " from word " << value.columns[0] << " of page "
                       << value.row;
    }
    return out;
}

}  // namespace metabuffer::rtl

#include "rtl/signals.h"

#include <algorithm>

#include "formats/bus_side_band.h"

namespace metabuffer::rtl {
namespace {

constexpr int kLaneCountBits = 4;

constexpr int kFieldBits = 16;

std::uint64_t pack(std::uint16_t a, std::uint16_t b, std::uint16_t c, std::uint16_t d) {
    return std::uint64_t{a} | (std::uint64_t{b} << kFieldBits) | (std::uint64_t{c} << (2 * kFieldBits)) |
           (std::uint64_t{d} << (3 * kFieldBits));
}

std::uint16_t field(std::uint64_t word, int position) {
    return static_cast<std::uint16_t>(word >> (position * kFieldBits));
}

constexpr std::array<const char*, kTmdsChannels> kChannelNames{"BLUE", "GREEN", "RED"};

// The SystemC tracer keeps a reference to what it traces, so an enumeration is traced as the byte it is.
template <typename Enum>
const unsigned char& byte_of(const Enum& value) {
    static_assert(sizeof(Enum) == 1);
    return reinterpret_cast<const unsigned char&>(value);
}

}  // namespace

std::ostream& operator<<(std::ostream& out, const DviLink& value) {
    return out << (value.de ? "DE " : "") << (value.hsync ? "HSYNC " : "") << (value.vsync ? "VSYNC " : "")
               << value.data;
}

void sc_trace(sc_core::sc_trace_file* file, const DviLink& value, const std::string& name) {
    sc_core::sc_trace(file, value.de, name + ".DE");
    sc_core::sc_trace(file, value.hsync, name + ".HSYNC");
    sc_core::sc_trace(file, value.vsync, name + ".VSYNC");
    sc_core::sc_trace(file, value.data, name + ".DATA", kColourBits);
}

std::ostream& operator<<(std::ostream& out, const TmdsLink& value) {
    return out << "blue " << value.channels[0] << " green " << value.channels[1] << " red "
               << value.channels[2];
}

void sc_trace(sc_core::sc_trace_file* file, const TmdsLink& value, const std::string& name) {
    for (std::size_t i = 0; i < kTmdsChannels; ++i) {
        sc_core::sc_trace(file, value.channels[i], name + '.' + kChannelNames[i], kTmdsCharacterBits);
    }
}

void sc_trace(sc_core::sc_trace_file* file, const TmdsDisparities& value, const std::string& name) {
    constexpr int kSignedBits = 5;
    for (std::size_t i = 0; i < kTmdsChannels; ++i) {
        sc_core::sc_trace(file, value.channels[i], name + '.' + kChannelNames[i], kSignedBits);
    }
}

std::ostream& operator<<(std::ostream& out, const DecodedPixel& value) {
    return out << (value.valid ? "pixel " : "no pixel ") << value.address << ' ' << value.data;
}

void sc_trace(sc_core::sc_trace_file* file, const DecodedPixel& value, const std::string& name,
              int address_bits) {
    sc_core::sc_trace(file, value.valid, name + ".valid");
    sc_core::sc_trace(file, byte_of(value.kind), name + ".kind");
    sc_core::sc_trace(file, value.address, name + ".address", address_bits);
    sc_core::sc_trace(file, value.data, name + ".data", kColourBits);
}

bool operator==(const DecoderEvent& a, const DecoderEvent& b) {
    return a.rejected == b.rejected && a.cause == b.cause && a.pair_lost == b.pair_lost &&
           a.lost_number == b.lost_number && a.colour_start == b.colour_start && a.pair_good == b.pair_good &&
           a.number == b.number && a.row == b.row && a.table_row == b.table_row &&
           a.payload_bytes == b.payload_bytes && a.payload == b.payload;
}

std::ostream& operator<<(std::ostream& out, const DecoderEvent& value) {
    if (value.rejected) {
        out << "rejected(" << reject_cause_key(value.cause) << ") ";
    }
    if (value.pair_lost) {
        out << "lost " << value.lost_number << ' ';
    }
    if (value.colour_start) {
        out << "colour ";
    }
    if (value.row) {
        out << "row ";
    }
    return out << (value.pair_good ? "good " : "") << value.number;
}

void sc_trace(sc_core::sc_trace_file* file, const DecoderEvent& value, const std::string& name) {
    sc_core::sc_trace(file, value.rejected, name + ".rejected");
    sc_core::sc_trace(file, byte_of(value.cause), name + ".cause");
    sc_core::sc_trace(file, value.pair_lost, name + ".pair_lost");
    sc_core::sc_trace(file, value.colour_start, name + ".colour_start");
    sc_core::sc_trace(file, value.pair_good, name + ".pair_good");
    sc_core::sc_trace(file, value.number, name + ".number");
    sc_core::sc_trace(file, value.row, name + ".row");
}

BusBeat BusBeat::frame_start(std::uint32_t frame, bool last) {
    BusBeat beat;
    beat.kind = Kind::kFrameStart;
    beat.last = last;
    beat.frame = frame;
    return beat;
}

BusBeat BusBeat::table_row(std::uint32_t frame, std::uint32_t place, const ViewportRow& row, bool last) {
    BusBeat beat;
    beat.kind = Kind::kTableRow;
    beat.last = last;
    beat.frame = frame;
    beat.first = place;
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

bool operator==(const BusBeat& a, const BusBeat& b) {
    return a.kind == b.kind && a.last == b.last && a.frame == b.frame && a.count == b.count &&
           a.destination == b.destination && a.remaining == b.remaining && a.first == b.first &&
           std::equal(a.words.begin(), a.words.begin() + a.count, b.words.begin());
}

std::ostream& operator<<(std::ostream& out, const BusBeat& value) {
    switch (value.kind) {
        case BusBeat::Kind::kNone:
            return out << "none";
        case BusBeat::Kind::kFrameStart:
            return out << "start of frame " << value.frame;
        case BusBeat::Kind::kTableRow:
            return out << "row " << value.first << " of frame " << value.frame << " for "
                       << value.destination;
        case BusBeat::Kind::kPixels:
            return out << int{value.count} << " pixels to " << value.destination << ", " << value.remaining
                       << " to come";
    }
    return out;
}

void sc_trace(sc_core::sc_trace_file* file, const BusBeat& value, const std::string& name, int lanes) {
    sc_core::sc_trace(file, byte_of(value.kind), name + ".kind", BusSideBand::kKindBits);
    sc_core::sc_trace(file, value.last, name + ".last");
    sc_core::sc_trace(file, value.frame, name + ".frame");
    sc_core::sc_trace(file, value.destination, name + ".destination");
    sc_core::sc_trace(file, value.count, name + ".count", BusSideBand::kCountBits);
    sc_core::sc_trace(file, value.remaining, name + ".remaining", BusSideBand::kRemainingBits);
    sc_core::sc_trace(file, value.first, name + ".first");
    trace_lanes(file, value.words, lanes, name + ".word", kPixelBits);
}

bool operator==(const MemoryWrite& a, const MemoryWrite& b) {
    return a.enable == b.enable && a.device == b.device && a.address == b.address && a.data == b.data &&
           a.byte_mask == b.byte_mask;
}

std::ostream& operator<<(std::ostream& out, const MemoryWrite& value) {
    if (!value.enable) {
        return out << "no write";
    }
    return out << value.data << " to word " << value.address << " of device " << int{value.device};
}

void sc_trace(sc_core::sc_trace_file* file, const MemoryWrite& value, const std::string& name,
              int address_bits) {
    sc_core::sc_trace(file, value.enable, name + ".enable");
    sc_core::sc_trace(file, value.device, name + ".device", 1);
    sc_core::sc_trace(file, value.address, name + ".address", address_bits);
    sc_core::sc_trace(file, value.data, name + ".data");
    sc_core::sc_trace(file, value.byte_mask, name + ".byte_mask");
}

bool operator==(const MemoryCommand& a, const MemoryCommand& b) {
    return a.kind == b.kind && a.bank == b.bank && a.row == b.row && a.count == b.count &&
           a.byte_mask == b.byte_mask &&
           std::equal(a.columns.begin(), a.columns.begin() + a.count, b.columns.begin());
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

void sc_trace(sc_core::sc_trace_file* file, const MemoryCommand& value, const std::string& name,
              int page_bits, int lanes, int column_bits) {
    sc_core::sc_trace(file, byte_of(value.kind), name + ".kind", 3);
    sc_core::sc_trace(file, value.bank, name + ".bank", 3);
    sc_core::sc_trace(file, value.row, name + ".row", page_bits);
    sc_core::sc_trace(file, value.count, name + ".count", kLaneCountBits);
    sc_core::sc_trace(file, value.byte_mask, name + ".byte_mask");
    trace_lanes(file, value.columns, lanes, name + ".column", column_bits);
}

std::ostream& operator<<(std::ostream& out, const WriteBlock& value) {
    return out << value.words << " words from word " << value.address << " on";
}

void sc_trace(sc_core::sc_trace_file* file, const WriteBlock& value, const std::string& name) {
    sc_core::sc_trace(file, value.address, name + ".address");
    sc_core::sc_trace(file, value.words, name + ".words");
    sc_core::sc_trace(file, value.byte_mask, name + ".byte_mask");
}

bool operator==(const MemoryData& a, const MemoryData& b) {
    return a.count == b.count && std::equal(a.words.begin(), a.words.begin() + a.count, b.words.begin());
}

std::ostream& operator<<(std::ostream& out, const MemoryData& value) {
    return out << int{value.count} << " words";
}

void sc_trace(sc_core::sc_trace_file* file, const MemoryData& value, const std::string& name, int lanes) {
    sc_core::sc_trace(file, value.count, name + ".count", kLaneCountBits);
    trace_lanes(file, value.words, lanes, name + ".word", kPixelBits);
}

bool operator==(const FifoWrite& a, const FifoWrite& b) {
    return a.count == b.count && a.address == b.address &&
           std::equal(a.words.begin(), a.words.begin() + a.count, b.words.begin());
}

std::ostream& operator<<(std::ostream& out, const FifoWrite& value) {
    return out << int{value.count} << " words from address " << value.address << " on";
}

void sc_trace(sc_core::sc_trace_file* file, const FifoWrite& value, const std::string& name,
              int address_bits) {
    sc_core::sc_trace(file, value.count, name + ".count", kLaneCountBits);
    sc_core::sc_trace(file, value.address, name + ".address", address_bits);
}

std::ostream& operator<<(std::ostream& out, const FifoRead& value) {
    if (!value.enable) {
        return out << "no read";
    }
    return out << "address " << value.address;
}

void sc_trace(sc_core::sc_trace_file* file, const FifoRead& value, const std::string& name,
              int address_bits) {
    sc_core::sc_trace(file, value.enable, name + ".enable");
    sc_core::sc_trace(file, value.address, name + ".address", address_bits);
}

std::ostream& operator<<(std::ostream& out, const FifoRelease& value) {
    return out << value.oldest << " oldest, " << value.newest << " newest";
}

void sc_trace(sc_core::sc_trace_file* file, const FifoRelease& value, const std::string& name,
              int count_bits) {
    sc_core::sc_trace(file, value.oldest, name + ".oldest", count_bits);
    sc_core::sc_trace(file, value.newest, name + ".newest", count_bits);
}

bool operator==(const FrontTable& a, const FrontTable& b) { return a.rows == b.rows && a.slots == b.slots; }

std::ostream& operator<<(std::ostream& out, const FrontTable& value) {
    return out << value.rows.size() << " rows, " << value.slots.size() << " slots";
}

/// Tables are memories, which are not in the waveform; the bus shows which composer is addressed.
void sc_trace(sc_core::sc_trace_file* /*file*/, const FrontTable& /*value*/, const std::string& /*name*/) {}

std::ostream& operator<<(std::ostream& out, const PipePixel& value) {
    return out << (value.valid ? (value.lost ? "lost pixel " : "pixel ") : "no pixel ") << value.pixel.word();
}

void sc_trace(sc_core::sc_trace_file* file, const PipePixel& value, const std::string& name) {
    sc_core::sc_trace(file, value.valid, name + ".valid");
    sc_core::sc_trace(file, value.lost, name + ".lost");
    // A Pixel is one 64-bit word; the tracer wants a reference to the word itself.
    static_assert(sizeof(Pixel) == sizeof(std::uint64_t));
    sc_core::sc_trace(file, reinterpret_cast<const std::uint64_t&>(value.pixel), name + ".pixel");
}

}  // namespace metabuffer::rtl

namespace metabuffer {

std::ostream& operator<<(std::ostream& out, const TmdsDisturbance& value) {
    for (std::size_t i = 0; i < kTmdsChannels; ++i) {
        out << rtl::kChannelNames[i] << " flips " << value.flips[i] << " late by "
            << int{value.late_characters[i]} << " characters and " << int{value.late_bits[i]} << " bits ";
    }
    return out;
}

void sc_trace(sc_core::sc_trace_file* file, const TmdsDisturbance& value, const std::string& name) {
    constexpr int kLateBits = 4;
    for (std::size_t i = 0; i < kTmdsChannels; ++i) {
        const std::string channel = name + '.' + rtl::kChannelNames[i];
        sc_core::sc_trace(file, value.flips[i], channel + "_flips", kTmdsCharacterBits);
        sc_core::sc_trace(file, value.late_bits[i], channel + "_late_bits", kLateBits);
        sc_core::sc_trace(file, value.late_characters[i], channel + "_late_characters", kLateBits);
    }
}

void sc_trace(sc_core::sc_trace_file* file, const TmdsAlignment& value, const std::string& name) {
    constexpr int kNumberBits = 4;
    sc_core::sc_trace(file, value.phase, name + ".phase", kNumberBits);
    sc_core::sc_trace(file, value.found, name + ".found");
    sc_core::sc_trace(file, value.candidate, name + ".candidate", kNumberBits);
    sc_core::sc_trace(file, value.run, name + ".run", kNumberBits);
}

}  // namespace metabuffer

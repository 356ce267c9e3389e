#pragma once

#include <array>
#include <cstdint>
#include <ostream>
#include <string>
#include <systemc>
#include <vector>

#include "datapath/link/pair_event.h"
#include "formats/control_scanline.h"
#include "formats/pixel.h"
#include "formats/tmds.h"
#include "formats/viewport_table.h"
#include "report/report.h"

/// The values that the machine's signals carry. Each has operator==, operator<< and sc_trace, as sc_signal
/// needs. A sc_trace may be told how wide the value is in its place.
namespace metabuffer::rtl {

/// Width of a number in a waveform, where whoever adds it does not say how many bits it has.
constexpr int kNumberBits = 32;

/// What a DVI receiver chip gives at each pixel clock.
struct DviLink {
    std::uint32_t data = 0;  ///< 24 bits, meaningful while de is high
    bool de = false;
    bool hsync = false;
    bool vsync = false;
};
inline bool operator==(const DviLink& a, const DviLink& b) {
    return a.data == b.data && a.de == b.de && a.hsync == b.hsync && a.vsync == b.vsync;
}
std::ostream& operator<<(std::ostream& out, const DviLink& value);
void sc_trace(sc_core::sc_trace_file* file, const DviLink& value, const std::string& name);

/// The characters that a DVI link's three channels carry in a pixel clock, by TmdsChannel.
struct TmdsLink {
    std::array<TmdsCharacter, kTmdsChannels> channels{kTmdsControl[0], kTmdsControl[0], kTmdsControl[0]};
};
inline bool operator==(const TmdsLink& a, const TmdsLink& b) { return a.channels == b.channels; }
std::ostream& operator<<(std::ostream& out, const TmdsLink& value);
/// As NAME.BLUE, NAME.GREEN and NAME.RED.
void sc_trace(sc_core::sc_trace_file* file, const TmdsLink& value, const std::string& name);

/// What a DVI encoder keeps of each channel: ones less zeros since the last control character.
struct TmdsDisparities {
    std::array<int, kTmdsChannels> channels{};
};
inline bool operator==(const TmdsDisparities& a, const TmdsDisparities& b) {
    return a.channels == b.channels;
}
void sc_trace(sc_core::sc_trace_file* file, const TmdsDisparities& value, const std::string& name);

/// A pixel that the decoder has found: half a memory word.
struct DecodedPixel {
    bool valid = false;
    FrameKind kind = FrameKind::kColour;
    std::uint32_t address = 0;  ///< word in the bank: y * image width + x
    std::uint32_t data = 0;
};
inline bool operator==(const DecodedPixel& a, const DecodedPixel& b) {
    return a.valid == b.valid && a.kind == b.kind && a.address == b.address && a.data == b.data;
}
std::ostream& operator<<(std::ostream& out, const DecodedPixel& value);
void sc_trace(sc_core::sc_trace_file* file, const DecodedPixel& value, const std::string& name,
              int address_bits = kNumberBits);

/// What the decoder has learnt in a clock about frames and pairs.
struct DecoderEvent : PairEvent {
    bool row = false;  ///< a row of the colour frame's table, one per clock
    ViewportRow table_row;
    /// Bytes of the payload of the depth frame's control scanline, as they pass; they count if the pair turns out good.
    std::uint8_t payload_bytes = 0;
    std::array<std::uint8_t, kLinkBytesPerPixel> payload{};
};
bool operator==(const DecoderEvent& a, const DecoderEvent& b);
std::ostream& operator<<(std::ostream& out, const DecoderEvent& value);
void sc_trace(sc_core::sc_trace_file* file, const DecoderEvent& value, const std::string& name);

/// Adds the first `lanes` of an array's values to a waveform, as NAME_0, NAME_1, ...
template <typename Value, std::size_t kLanes>
void trace_lanes(sc_core::sc_trace_file* file, const std::array<Value, kLanes>& values, int lanes,
                 const std::string& name, int width_bits = 8 * sizeof(Value)) {
    for (int lane = 0; lane < lanes; ++lane) {
        sc_core::sc_trace(file, values[static_cast<std::size_t>(lane)], name + "_" + std::to_string(lane),
                          width_bits);
    }
}

/// The widest bus, in pixels per beat.
constexpr int kMaximumBeatPixels = 8;

/// What a renderer's bus carries in a core clock. Every beat names its frame and its position in it, so that a composer
/// notices lost beats before it.
struct BusBeat {
    enum class Kind : std::uint8_t {
        kNone,
        kFrameStart,  ///< a new frame's table follows, or ends here if `last`
        kTableRow,    ///< one row in words [0] and [1]; `last` in the table's last row
        kPixels,      ///< `count` pixels of a burst
    };
    Kind kind = Kind::kNone;
    bool last = false;
    std::uint32_t frame = 0;  ///< number of the composited frame that it is a beat of, from 0
    std::uint8_t count = 0;
    std::uint16_t destination = 0;  ///< display of the composer addressed, from 1
    std::uint32_t remaining = 0;    ///< pixels of the burst after this beat
    /// kPixels: index in the segment of the beat's first pixel; kTableRow: index in the table. From 0.
    std::uint32_t first = 0;
    std::array<std::uint64_t, kMaximumBeatPixels> words{};

    static BusBeat frame_start(std::uint32_t frame, bool last);
    static BusBeat table_row(std::uint32_t frame, std::uint32_t place, const ViewportRow& row, bool last);
    ViewportRow row() const;
    /// Words that a beat may have: a row of the table has two, however many clocks it takes.
    static constexpr int lanes(int pixels_per_beat) {
        constexpr int kRowWords = kControlRowBytes / 8;
        return pixels_per_beat > kRowWords ? pixels_per_beat : kRowWords;
    }
};
bool operator==(const BusBeat& a, const BusBeat& b);
std::ostream& operator<<(std::ostream& out, const BusBeat& value);
/// lanes: words that the bus carries in a beat; they are NAME.word_0 and so on.
void sc_trace(sc_core::sc_trace_file* file, const BusBeat& value, const std::string& name, int lanes = 0);

/// What the link writes into a frame memory at a clock of the link.
struct MemoryWrite {
    bool enable = false;
    std::uint8_t device = 0;     ///< which of the two
    std::uint32_t address = 0;   ///< word in the device
    std::uint64_t data = 0;      ///< a pixel's word
    std::uint8_t byte_mask = 0;  ///< bit b: byte b of the word is written
    static constexpr std::uint8_t kColourBytes = 0x07;
    static constexpr std::uint8_t kDepthBytes = 0xF8;  ///< alpha and Z
};
bool operator==(const MemoryWrite& a, const MemoryWrite& b);
std::ostream& operator<<(std::ostream& out, const MemoryWrite& value);
void sc_trace(sc_core::sc_trace_file* file, const MemoryWrite& value, const std::string& name,
              int address_bits = kNumberBits);

/// What an input framebuffer's bus port asks of its frame memory in a core clock.
struct MemoryCommand {
    enum class Kind : std::uint8_t {
        kNone,
        kActivate,      ///< opens a page of the bank
        kRead,          ///< `count` words of the bank's open page
        kPrecharge,     ///< closes the bank's page
        kPrechargeAll,  ///< closes every bank's page
        kRefresh,       ///< the same, and no bank takes a command for refresh_cycles, this clock included
        kWrite,         ///< with shared ports: `count` words of the link into the bank's open page
    };
    Kind kind = Kind::kNone;
    std::uint8_t bank = 0;
    std::uint32_t row = 0;  ///< of kActivate, kRead and kWrite: the page
    std::uint8_t count = 0;
    std::uint8_t byte_mask = 0;  ///< of kWrite: bit b, byte b of each word is written
    std::array<std::uint32_t, kMaximumBeatPixels>
        columns{};  ///< of kRead and kWrite: word in the page, for each word of the beat
};
bool operator==(const MemoryCommand& a, const MemoryCommand& b);
std::ostream& operator<<(std::ostream& out, const MemoryCommand& value);
/// lanes: words that the memory reads in a clock; their columns are NAME.column_0 and so on.
void sc_trace(sc_core::sc_trace_file* file, const MemoryCommand& value, const std::string& name,
              int page_bits = kNumberBits, int lanes = 0, int column_bits = kNumberBits);

/// The destination of a block of the link's words that waits to be written. Its words stay in the write buffer.
struct WriteBlock {
    std::uint64_t address = 0;  ///< of its first word in the memory, counted over both devices
    std::uint32_t words = 0;
    std::uint8_t byte_mask = 0;
};
inline bool operator==(const WriteBlock& a, const WriteBlock& b) {
    return a.address == b.address && a.words == b.words && a.byte_mask == b.byte_mask;
}
std::ostream& operator<<(std::ostream& out, const WriteBlock& value);
void sc_trace(sc_core::sc_trace_file* file, const WriteBlock& value, const std::string& name);

/// The words that a frame memory puts out.
struct MemoryData {
    std::uint8_t count = 0;  ///< 0: none
    std::array<std::uint64_t, kMaximumBeatPixels> words{};
};
bool operator==(const MemoryData& a, const MemoryData& b);
std::ostream& operator<<(std::ostream& out, const MemoryData& value);
/// lanes: words that the memory puts out in a clock; they are NAME.word_0 and so on.
void sc_trace(sc_core::sc_trace_file* file, const MemoryData& value, const std::string& name, int lanes = 0);

/// What a composer writes into its FIFO in a core clock: a beat's pixels, at addresses that follow each other.
struct FifoWrite {
    std::uint8_t count = 0;     ///< 0: none
    std::uint32_t address = 0;  ///< of the first; after the FIFO's last address comes its first
    std::array<std::uint64_t, kMaximumBeatPixels> words{};
};
bool operator==(const FifoWrite& a, const FifoWrite& b);
std::ostream& operator<<(std::ostream& out, const FifoWrite& value);
/// Without the words, see trace_lanes.
void sc_trace(sc_core::sc_trace_file* file, const FifoWrite& value, const std::string& name,
              int address_bits = kNumberBits);

/// What a composer reads from its FIFO in a core clock.
struct FifoRead {
    bool enable = false;
    std::uint32_t address = 0;
};
inline bool operator==(const FifoRead& a, const FifoRead& b) {
    return a.enable == b.enable && a.address == b.address;
}
std::ostream& operator<<(std::ostream& out, const FifoRead& value);
void sc_trace(sc_core::sc_trace_file* file, const FifoRead& value, const std::string& name,
              int address_bits = kNumberBits);

/// Pixels that a composer's FIFO need not hold any more.
struct FifoRelease {
    std::uint32_t oldest = 0;  ///< that have had their last use
    std::uint32_t newest = 0;  ///< of a frame that is abandoned

    bool any() const { return oldest > 0 || newest > 0; }
};
inline bool operator==(const FifoRelease& a, const FifoRelease& b) {
    return a.oldest == b.oldest && a.newest == b.newest;
}
std::ostream& operator<<(std::ostream& out, const FifoRelease& value);
void sc_trace(sc_core::sc_trace_file* file, const FifoRelease& value, const std::string& name,
              int count_bits = kNumberBits);

/// The table of the pair in the front bank: its valid rows, and which row owns each slot of the bus. It does not change
/// from one swap of the banks to the next.
struct FrontTable {
    ViewportTable rows;
    std::vector<int> slots;  ///< index of a row; none under a policy without slots
};
bool operator==(const FrontTable& a, const FrontTable& b);
std::ostream& operator<<(std::ostream& out, const FrontTable& value);
void sc_trace(sc_core::sc_trace_file* file, const FrontTable& value, const std::string& name);

/// One stage of a pipeline: a raster pixel, or none.
struct PipePixel {
    Pixel pixel;
    bool valid = false;
    bool lost = false;  ///< a composer has abandoned the frame, since beats of it were lost on its bus
};
inline bool operator==(const PipePixel& a, const PipePixel& b) {
    return a.pixel == b.pixel && a.valid == b.valid && a.lost == b.lost;
}
std::ostream& operator<<(std::ostream& out, const PipePixel& value);
void sc_trace(sc_core::sc_trace_file* file, const PipePixel& value, const std::string& name);

}  // namespace metabuffer::rtl

// Found by the namespace of their arguments, which are plain structures of model/formats.
namespace metabuffer {

std::ostream& operator<<(std::ostream& out, const TmdsDisturbance& value);
void sc_trace(sc_core::sc_trace_file* file, const TmdsDisturbance& value, const std::string& name);
void sc_trace(sc_core::sc_trace_file* file, const TmdsAlignment& value, const std::string& name);

}  // namespace metabuffer

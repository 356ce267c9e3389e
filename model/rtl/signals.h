#pragma once

#include <array>
#include <cstdint>
#include <ostream>
#include <vector>

#include "datapath/link/pair_event.h"
#include "formats/bus_side_band.h"
#include "formats/control_scanline.h"
#include "formats/pixel.h"
#include "formats/tmds.h"
#include "formats/viewport_table.h"
#include "report/report.h"
#include "rtl/fields.h"

/// The values that the machine's signals carry, with their lists of fields, see rtl/fields.h.
namespace metabuffer::rtl {

constexpr int kLaneCountBits = 4;

/// What a DVI receiver chip gives at each pixel clock.
struct DviLink {
    std::uint32_t data = 0;  ///< 24 bits, meaningful while de is high
    bool de = false;
    bool hsync = false;
    bool vsync = false;

    template <typename See>
    static void visit_fields(const See& see) {
        see("DE", &DviLink::de);
        see("HSYNC", &DviLink::hsync);
        see("VSYNC", &DviLink::vsync);
        see("DATA", &DviLink::data, kColourBits);
    }
};

/// The characters that a DVI link's three channels carry in a pixel clock, by TmdsChannel.
struct TmdsLink {
    std::array<TmdsCharacter, kTmdsChannels> channels{kTmdsControl[0], kTmdsControl[0], kTmdsControl[0]};

    template <typename See>
    static void visit_fields(const See& see) {
        for (std::size_t i = 0; i < kTmdsChannels; ++i) {
            const auto channel = [i](const TmdsLink& of) -> auto& { return of.channels[i]; };
            see(kTmdsChannelNames[i], channel, kTmdsCharacterBits);
        }
    }
};

/// What a DVI encoder keeps of each channel: ones less zeros since the last control character.
struct TmdsDisparities {
    std::array<int, kTmdsChannels> channels{};

    template <typename See>
    static void visit_fields(const See& see) {
        constexpr int kSignedBits = 5;
        for (std::size_t i = 0; i < kTmdsChannels; ++i) {
            const auto channel = [i](const TmdsDisparities& of) -> auto& { return of.channels[i]; };
            see(kTmdsChannelNames[i], channel, kSignedBits);
        }
    }
};

/// A pixel that the decoder has found: half a memory word.
struct DecodedPixel {
    bool valid = false;
    FrameKind kind = FrameKind::kColour;
    std::uint32_t address = 0;  ///< word in the device: y * image width + x
    std::uint32_t data = 0;

    template <typename See>
    static void visit_fields(const See& see, int address_bits = kAllBits) {
        see("valid", &DecodedPixel::valid);
        see("kind", &DecodedPixel::kind);
        see("address", &DecodedPixel::address, address_bits);
        see("data", &DecodedPixel::data, kColourBits);
    }
};

/// What the decoder has learnt in a clock about frames and pairs.
struct DecoderEvent : PairEvent {
    bool row = false;  ///< a row of the colour frame's table, one per clock
    ViewportRow table_row;
    /// Bytes of the payload of the depth frame's control scanline, as they pass; they count if the pair turns out good.
    std::uint8_t payload_bytes = 0;
    std::array<std::uint8_t, kLinkBytesPerPixel> payload{};

    template <typename See>
    static void visit_fields(const See& see) {
        see("rejected", &DecoderEvent::rejected);
        see("cause", &DecoderEvent::cause);
        see("pair_lost", &DecoderEvent::pair_lost);
        see("lost_number", &DecoderEvent::lost_number, kUntraced);
        see("colour_start", &DecoderEvent::colour_start);
        see("pair_good", &DecoderEvent::pair_good);
        see("number", &DecoderEvent::number);
        see("row", &DecoderEvent::row);
        see("table_row", &DecoderEvent::table_row, kUntraced);
        see("payload_bytes", &DecoderEvent::payload_bytes, kUntraced);
        see("payload", &DecoderEvent::payload, kUntraced);
    }
};

/// The widest bus, in pixels per beat.
constexpr int kMaximumBeatPixels = 8;

/// What a renderer's bus carries in a core clock. Every beat has its frame's number and its index within the frame, so a
/// composer notices that beats before it were lost.
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
    static BusBeat table_row(std::uint32_t frame, std::uint32_t index, const ViewportRow& row, bool last);
    ViewportRow row() const;
    /// Words that a beat may have: a row of the table has two, however many clocks it takes.
    static constexpr int lanes(int pixels_per_beat) {
        constexpr int kRowWords = kControlRowBytes / 8;
        return pixels_per_beat > kRowWords ? pixels_per_beat : kRowWords;
    }

    /// lanes: words that the bus carries in a beat; they are NAME.word_0 and so on.
    template <typename See>
    static void visit_fields(const See& see, int lanes = 0) {
        see("kind", &BusBeat::kind, BusSideBand::kKindBits);
        see("last", &BusBeat::last);
        see("frame", &BusBeat::frame);
        see("destination", &BusBeat::destination);
        see("count", &BusBeat::count, BusSideBand::kCountBits);
        see("remaining", &BusBeat::remaining, BusSideBand::kRemainingBits);
        see("first", &BusBeat::first);
        see("word", &BusBeat::words, &BusBeat::count, lanes);
    }
};

/// What the link writes into a frame memory at a clock of the link.
struct MemoryWrite {
    bool enable = false;
    std::uint8_t device = 0;     ///< which of the two
    std::uint32_t address = 0;   ///< word in the device
    std::uint64_t data = 0;      ///< a pixel's word
    std::uint8_t byte_mask = 0;  ///< bit b: byte b of the word is written
    static constexpr std::uint8_t kColourBytes = 0x07;
    static constexpr std::uint8_t kDepthBytes = 0xF8;  ///< alpha and Z

    template <typename See>
    static void visit_fields(const See& see, int address_bits = kAllBits) {
        see("enable", &MemoryWrite::enable);
        see("device", &MemoryWrite::device, 1);
        see("address", &MemoryWrite::address, address_bits);
        see("data", &MemoryWrite::data);
        see("byte_mask", &MemoryWrite::byte_mask);
    }
};

/// What an input framebuffer's bus port asks of its memory controller in a core clock.
struct MemoryRequest {
    /// All banks: a frame begins with no page open. No words are asked for then, nor in the precharge_cycles after it.
    bool close = false;
    bool give_up = false;  ///< the words asked for in the clock before are not wanted any more
    std::uint8_t count = 0;
    std::array<std::uint32_t, kMaximumBeatPixels> addresses{};  ///< of `count` words in the memory

    /// lanes: words that the memory reads in a clock; their addresses are NAME.address_0 and so on.
    template <typename See>
    static void visit_fields(const See& see, int lanes = 0, int address_bits = kAllBits) {
        see("close", &MemoryRequest::close);
        see("give_up", &MemoryRequest::give_up);
        see("count", &MemoryRequest::count, kLaneCountBits);
        see("address", &MemoryRequest::addresses, &MemoryRequest::count, lanes, address_bits);
    }
};

/// What becomes of the words asked for in this clock.
struct MemoryAnswer {
    enum class Kind : std::uint8_t {
        kNone,     ///< none are asked for
        kRead,     ///< the first `count` of them are read
        kOpen,     ///< their page is being opened
        kRefresh,  ///< the memory is being refreshed
        kWrite,    ///< with shared ports: the memory takes words of the link
    };
    Kind kind = Kind::kNone;
    std::uint8_t count = 0;
    bool miss = false;  ///< of kRead and kOpen: the page was not open before this clock

    template <typename See>
    static void visit_fields(const See& see) {
        see("kind", &MemoryAnswer::kind, 3);
        see("count", &MemoryAnswer::count, kLaneCountBits);
        see("miss", &MemoryAnswer::miss);
    }
};

/// What a memory controller asks of its frame memory in a core clock.
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

    /// lanes: words that the memory reads in a clock; their columns are NAME.column_0 and so on.
    template <typename See>
    static void visit_fields(const See& see, int page_bits = kAllBits, int lanes = 0,
                             int column_bits = kAllBits) {
        see("kind", &MemoryCommand::kind, 3);
        see("bank", &MemoryCommand::bank, 3);
        see("row", &MemoryCommand::row, page_bits);
        see("count", &MemoryCommand::count, kLaneCountBits);
        see("byte_mask", &MemoryCommand::byte_mask);
        see("column", &MemoryCommand::columns, &MemoryCommand::count, lanes, column_bits);
    }
};
std::ostream& operator<<(std::ostream& out, const MemoryCommand& value);

/// The destination of a block of the link's words that waits to be written. Its words stay in the write buffer.
struct WriteBlock {
    std::uint64_t address = 0;  ///< of its first word in the memory, counted over both devices
    std::uint32_t words = 0;
    std::uint8_t byte_mask = 0;

    template <typename See>
    static void visit_fields(const See& see) {
        see("address", &WriteBlock::address);
        see("words", &WriteBlock::words);
        see("byte_mask", &WriteBlock::byte_mask);
    }
};

/// The words that a frame memory puts out.
struct MemoryData {
    std::uint8_t count = 0;  ///< 0: none
    std::array<std::uint64_t, kMaximumBeatPixels> words{};

    /// lanes: words that the memory puts out in a clock; they are NAME.word_0 and so on.
    template <typename See>
    static void visit_fields(const See& see, int lanes = 0) {
        see("count", &MemoryData::count, kLaneCountBits);
        see("word", &MemoryData::words, &MemoryData::count, lanes);
    }
};

/// What a composer writes into its FIFO in a core clock: a beat's pixels, at addresses that follow each other.
struct FifoWrite {
    std::uint8_t count = 0;     ///< 0: none
    std::uint32_t address = 0;  ///< of the first; after the FIFO's last address comes its first
    std::array<std::uint64_t, kMaximumBeatPixels> words{};

    /// The words are not in the waveform: those of the bus's beat are.
    template <typename See>
    static void visit_fields(const See& see, int address_bits = kAllBits) {
        see("count", &FifoWrite::count, kLaneCountBits);
        see("address", &FifoWrite::address, address_bits);
        see("word", &FifoWrite::words, &FifoWrite::count, kUntraced);
    }
};

/// What a composer reads from its FIFO in a core clock.
struct FifoRead {
    bool enable = false;
    std::uint32_t address = 0;

    template <typename See>
    static void visit_fields(const See& see, int address_bits = kAllBits) {
        see("enable", &FifoRead::enable);
        see("address", &FifoRead::address, address_bits);
    }
};

/// Pixels that a composer's FIFO need not hold any more.
struct FifoRelease {
    std::uint32_t oldest = 0;  ///< how many of the oldest: they have had their last use
    std::uint32_t newest = 0;  ///< how many of the newest: their frame is abandoned

    bool any() const { return oldest > 0 || newest > 0; }

    template <typename See>
    static void visit_fields(const See& see, int count_bits = kAllBits) {
        see("oldest", &FifoRelease::oldest, count_bits);
        see("newest", &FifoRelease::newest, count_bits);
    }
};

/// The table of the pair in the front device: its valid rows, and which row owns each slot of the bus. It changes only
/// when the devices are swapped.
struct FrontTable {
    ViewportTable rows;
    std::vector<int> slots;  ///< index of a row; none under a policy without slots

    /// Tables are memories, which are not in the waveform; the bus shows which composer is addressed.
    template <typename See>
    static void visit_fields(const See& see) {
        see("rows", &FrontTable::rows, kUntraced);
        see("slots", &FrontTable::slots, kUntraced);
    }
};

/// One stage of a pipeline: a raster pixel, or none.
struct PipePixel {
    Pixel pixel;
    bool valid = false;
    bool lost = false;  ///< a composer has abandoned the frame, since beats of it were lost on its bus

    template <typename See>
    static void visit_fields(const See& see) {
        see("valid", &PipePixel::valid);
        see("lost", &PipePixel::lost);
        // A Pixel is one 64-bit word; the tracer wants a reference to the word itself.
        static_assert(sizeof(Pixel) == sizeof(std::uint64_t));
        const auto word = [](const PipePixel& of) -> auto& {
            return reinterpret_cast<const std::uint64_t&>(of.pixel);
        };
        see("pixel", word);
    }
};

}  // namespace metabuffer::rtl

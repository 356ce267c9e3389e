#pragma once

#include <tlm_utils/passthrough_target_socket.h>
#include <tlm_utils/simple_initiator_socket.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <tlm>
#include <vector>

#include "datapath/link/pair_event.h"
#include "formats/control_scanline.h"
#include "formats/image.h"
#include "formats/pixel_planes.h"
#include "formats/stored_image.h"
#include "formats/viewport_table.h"
#include "report/report.h"
#include "tlm/buffer_time.h"

/// What the transactions between two boxes carry. Every box has standard TLM-2.0 sockets and generic payloads; these
/// extensions hold what the standard fields cannot. Core clocks and DVI clocks are counted from time 0, as everywhere;
/// docs/transaction-level.md describes each socket.
namespace metabuffer::tlm {

using Payload = ::tlm::tlm_generic_payload;
using Phase = ::tlm::tlm_phase;

/// An extension that its Message owns, as it owns the payload.
template <typename Self>
class Extension : public ::tlm::tlm_extension<Self> {
  public:
    ::tlm::tlm_extension_base* clone() const override { return new Self(static_cast<const Self&>(*this)); }
    void copy_from(const ::tlm::tlm_extension_base& other) override {
        static_cast<Self&>(*this) = static_cast<const Self&>(other);
    }
};

/// A payload with its extension, for the module that starts its transactions. The command is IGNORE: the extension
/// holds everything.
template <typename Content>
class Message {
  public:
    Message() {
        payload_.set_command(::tlm::TLM_IGNORE_COMMAND);
        payload_.set_extension(&content_);
    }
    Message(const Message&) = delete;
    Message& operator=(const Message&) = delete;
    ~Message() { payload_.clear_extension(&content_); }

    Content* operator->() { return &content_; }
    Content& operator*() { return content_; }
    Payload& payload() {
        payload_.set_response_status(::tlm::TLM_INCOMPLETE_RESPONSE);
        return payload_;
    }

  private:
    Payload payload_;
    Content content_;
};

/// The three transports of a message, which takes no time.
template <typename Socket>
void transport(Socket& socket, Payload& payload) {
    sc_core::sc_time delay = sc_core::SC_ZERO_TIME;
    socket->b_transport(payload, delay);
}
template <typename Socket>
void transport_forward(Socket& socket, Payload& payload, Phase phase) {
    sc_core::sc_time delay = sc_core::SC_ZERO_TIME;
    socket->nb_transport_fw(payload, phase, delay);
}
template <typename Socket>
void transport_backward(Socket& socket, Payload& payload, Phase phase) {
    sc_core::sc_time delay = sc_core::SC_ZERO_TIME;
    socket->nb_transport_bw(payload, phase, delay);
}

/// The extension of a payload; an error of the model if there is none.
template <typename Content>
Content& content_of(Payload& payload) {
    Content* content = nullptr;
    payload.get_extension(content);
    if (content == nullptr) {
        const char* const message = "a transaction came without the extension that it needs";
        SC_REPORT_ERROR("/metabuffer/tlm/extension", message);
        throw std::logic_error(message);  // if error reports are set not to throw
    }
    return *content;
}

/// The protocol of a kind of boundary, by the extension that its payloads must have. The extensions and phases are
/// not ignorable, so these are not the base protocol, and a socket binds to one of its own kind only.
template <typename Content>
struct Protocol {
    using tlm_payload_type = Payload;
    using tlm_phase_type = Phase;
};

constexpr unsigned kSocketBits = 32;  ///< a parameter of every socket; nothing here depends on it
template <typename Module, typename Content>
using InitiatorSocket = ::tlm_utils::simple_initiator_socket<Module, kSocketBits, Protocol<Content>>;
template <typename Module, typename Content>
using TargetSocket = ::tlm_utils::passthrough_target_socket<Module, kSocketBits, Protocol<Content>>;
template <typename Module, typename Content>
using OptionalTargetSocket =
    ::tlm_utils::passthrough_target_socket_optional<Module, kSocketBits, Protocol<Content>>;
/// The base class of each target socket of a protocol, whatever its module.
template <typename Content>
using AnyTargetSocket =
    ::tlm::tlm_base_target_socket_b<kSocketBits, ::tlm::tlm_fw_transport_if<Protocol<Content>>,
                                    ::tlm::tlm_bw_transport_if<Protocol<Content>>>;

/// DVI link, dvi_source to dvi_decoder: a frame, sent when its first clock is on the link.
struct DviFrame : Extension<DviFrame> {
    const StoredImage* image = nullptr;  ///< lives as long as scenario and source
    std::vector<std::uint32_t> control;  ///< the control scanline as it is on the link
    int active_lines = 0;                ///< a fault may have changed it
    int last_line_pixels = 0;            ///< likewise
    std::int64_t first_edge = 0;         ///< DVI input clock of the frame's first clock
};

/// What the decoder has found, at the clock in which the input framebuffer reads it.
struct LinkEvent : PairEvent {
    std::int64_t edge = 0;                ///< DVI input clock
    ViewportTable table;                  ///< with colour_start
    std::vector<std::uint8_t> payload;    ///< with pair_good: of its depth frame's control scanline
    const StoredImage* colour = nullptr;  ///< with pair_good: whose colour half and whose depth half
    const StoredImage* depth = nullptr;
    std::int64_t last_pixel_edge = 0;  ///< with pair_good: the DVI input clock of the pair's last pixel
};

/// The pixels of a frame as they reach the input framebuffer, line by line.
struct LinkPixels {
    std::int64_t first_pixel_edge = 0;  ///< DVI input clock of the first one
    std::int64_t pixels = 0;
    int line_pixels = 0;
    int line_clocks = 0;

    std::int64_t edge_of(std::int64_t pixel) const {
        return first_pixel_edge + pixel / line_pixels * line_clocks + pixel % line_pixels;
    }
    /// How many have come by the end of a DVI input clock.
    std::int64_t come(std::int64_t through_edge) const {
        const std::int64_t clocks = through_edge - first_pixel_edge + 1;
        if (clocks <= 0 || pixels == 0) return 0;
        return std::min(pixels, clocks / line_clocks * line_pixels +
                                    std::min<std::int64_t>(clocks % line_clocks, line_pixels));
    }
};

/// dvi_decoder to input_framebuffer: a frame and the decoder's events for it.
struct DecodedFrame : Extension<DecodedFrame>, LinkPixels {
    std::vector<LinkEvent> events;  ///< in order of time
    std::optional<FrameKind> kind;  ///< none: the control scanline cannot be read
    std::uint32_t number = 0;       ///< with kind
};

/// A memory word holds a pixel.
constexpr unsigned kBytesPerWord = kPixelBits / 8;

/// input_framebuffer to frame_memory: the next words of a segment. The payload's address is that of the first and the
/// length that of all words, in bytes, 8 a word.
struct MemoryAccess : Extension<MemoryAccess> {
    bool new_frame = false;   ///< the first access of a frame
    bool broken_off = false;  ///< no access: the last one's wait ended at `cycle`, before its words
    /// No access, with shared ports: the words are a block from the link, which may be written from `cycle` on. Blocks
    /// come in order. An access comes after all blocks of its cycle or earlier, and after one more.
    bool write = false;
    std::int64_t settled_before = 0;  ///< with write: no access at an earlier clock follows
    std::int64_t cycle = 0;           ///< core clock in which the first word is wanted
    // The words lie in rows. The payload's address is in the first of them.
    int first_row_words = std::numeric_limits<int>::max();  ///< from the address on
    int row_words = 0;                                      ///< of each row after it
    int stride_words = 0;  ///< from the beginning of a row to that of the next
    // What the memory answers: a wait, for one thing, and words after it. 0 words: it is asked again after the wait.
    enum class Wait : std::uint8_t {
        kOpening,  ///< a page is opened
        kRefresh,
        kWrite,  ///< of the link's words
    };
    Wait wait = Wait::kOpening;
    int wait_cycles = 0;     ///< clocks without data before the first word
    bool page_miss = false;  ///< the opening of a page begins
    int words = 0;           ///< how many of the words asked for follow on the same page
    std::int64_t beats_before =
        kUnknownCycle;  ///< the first clock, after the wait, in which no beat can begin
};

/// How many of the words of an access follow each other, from the first on, before one that is on another page.
inline int words_on_page(const Payload& payload, const MemoryAccess& access, std::int64_t page_words) {
    auto address = static_cast<std::int64_t>(payload.get_address() / kBytesPerWord);
    const auto wanted = static_cast<std::int64_t>(payload.get_data_length() / kBytesPerWord);
    const std::int64_t page_end = (address / page_words + 1) * page_words;
    std::int64_t row_end = address + access.first_row_words;
    std::int64_t words = 0;
    while (address < page_end && words < wanted) {
        const std::int64_t end = std::min(row_end, page_end);
        words += end - address;
        if (end < row_end) break;
        address = row_end - access.row_words + access.stride_words;
        row_end += access.stride_words;
    }
    return static_cast<int>(std::min(words, wanted));
}

/// The pixels of a frame on a bus. Shared, since a frame's pixels are used long after they have been sent.
using FrameContent = std::shared_ptr<const PixelPlanes>;

/// input_framebuffer to bus to composer. The payload's address is the display, from 1.
struct BusTransfer : Extension<BusTransfer> {
    enum class Kind : std::uint8_t {
        kTable,       ///< a frame's table, to every composer
        kBeats,       ///< beats of a burst that follow each other without a gap
        kVerdict,     ///< nothing moves: what has BUSREADY been at an earlier beat?
        kEndOfBurst,  ///< nothing moves: from which clock on is a slot taken?
    };
    Kind kind = Kind::kTable;
    int frame = 0;

    // kTable
    const ViewportRow* row = nullptr;  ///< of the composer addressed, null if it has none
    std::int64_t table_cycle = 0;      ///< the composer knows the whole table
    FrameContent content;              ///< null without images

    // kBeats
    BeatRun beats;
    int remaining = 0;           ///< pixels of the burst after these beats
    bool heed_busready = false;  ///< the burst may be cut

    // kVerdict
    BurstBeat beat;

    // kEndOfBurst
    std::int64_t earliest = 0;  ///< no slot before this clock

    // What the composer answers.
    int pixels_taken = 0;  ///< kBeats: up to and including the beat after which BUSREADY fell or is not known
    BufferTime::Verdict verdict = BufferTime::Verdict::kTaken;  ///< kBeats, kVerdict
    SlotTime slot;                                              ///< kEndOfBurst
};

/// composer to bus to input_framebuffer, backward: what has become known. The payload's address is the display.
struct BusNotice : Extension<BusNotice> {
    std::int64_t slot_cycle = kUnknownCycle;  ///< busready_phase: a slot is taken from this clock on
    int frame = 0;                            ///< tableready_phase: whose table is taken
    std::int64_t table_cycle = 0;             ///< from this clock on
};

/// Room for a raster row of a smoothed segment, and for what it is mixed of.
struct SmoothingLines {
    /// A source row as its raster pixels use it: of their own source columns, and of those beside them.
    struct Source {
        int row = -1;  ///< in the segment; -1: none
        PixelPlanes own;
        PixelPlanes beside;
    };
    std::array<Source, 2> sources;         ///< by the source row's parity
    std::vector<std::uint32_t> weights_x;  ///< by raster column, from the segment's left on
    PixelPlanes mixed;
};

/// A pipeline, from composer to composer to output_framebuffer.
struct PipelineFrame : Extension<PipelineFrame> {
    int frame = 0;
    std::int64_t cycle = 0;  ///< pipeready_phase, startframe_phase: the core clock that writes the wire
    // b_transport: raster rows first_row to first_row + rows - 1, composited so far.
    int first_row = 0;
    int rows = 0;
    PixelPlanes* raster = nullptr;        ///< of that many rows; null without images
    PixelPlanes* line = nullptr;          ///< room for one raster row
    SmoothingLines* smoothing = nullptr;  ///< null in a machine that replicates
};

/// DVI out, output_framebuffer to dvi_display: a frame, sent when all its lines have been on the link.
struct ShownFrame : Extension<ShownFrame> {
    int frame = 0;
    const ColourImage* image = nullptr;  ///< null without images
};

TLM_DECLARE_EXTENDED_PHASE(pipeready_phase);   ///< backward: PIPEREADY rises
TLM_DECLARE_EXTENDED_PHASE(startframe_phase);  ///< forward: STARTFRAME
TLM_DECLARE_EXTENDED_PHASE(busready_phase);    ///< backward: the clock from which a slot is taken is known
TLM_DECLARE_EXTENDED_PHASE(tableready_phase);  ///< backward: likewise a table

}  // namespace metabuffer::tlm

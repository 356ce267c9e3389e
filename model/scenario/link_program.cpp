#include "scenario/link_program.h"

#include <algorithm>
#include <utility>

#include "formats/slot_payload.h"
#include "scenario/derived_timing.h"
#include "scenario/fault_kinds.h"

namespace metabuffer {
namespace {

constexpr std::uint32_t kByteBits = 0xFF;
constexpr auto kNoSuchKind = static_cast<FrameKind>(2);

void flip(std::vector<std::uint32_t>& link_pixels, int byte, std::uint32_t bits) {
    const auto pixel = static_cast<std::size_t>(byte / kLinkBytesPerPixel);
    const auto shift = static_cast<unsigned>(8 * (kLinkBytesPerPixel - 1 - byte % kLinkBytesPerPixel));
    link_pixels[pixel] ^= bits << shift;
}

/// A pixel with bits of one half flipped, as that half is on the link.
Pixel flipped(Pixel pixel, FrameKind half, std::uint32_t bits, DepthFormat format) {
    return half == FrameKind::kColour ? with_colour_half(pixel, colour_link_bits(pixel) ^ bits)
                                      : with_depth_half(pixel, depth_link_bits(pixel, format) ^ bits, format);
}

/// A copy of the image, made when its pixels are needed.
std::shared_ptr<const StoredImage> with_flipped_bits(std::shared_ptr<const StoredImage> original,
                                                     const Fault& fault, DepthFormat format) {
    const ImageSize size{original->width_pixels(), original->height_pixels()};
    return std::make_shared<const StoredImage>(size, [original = std::move(original), fault, format] {
        PixelImage image = original->pixels();
        Pixel& pixel = image.at(fault.x, fault.y);
        pixel = flipped(pixel, fault.frame, fault.bits, format);
        return image;
    });
}

/// The faults that change what is in one frame.
std::vector<const Fault*> corrupting_faults(const Scenario& scenario, int renderer, std::uint32_t pair,
                                            FrameKind frame) {
    std::vector<const Fault*> faults;
    for (const Fault& fault : scenario.faults) {
        if (fault.renderer != renderer || fault.pair != pair || fault.frame != frame) continue;
        if (fault_traits(fault.kind).changes_frame()) faults.push_back(&fault);
    }
    return faults;
}

/// Applies a fault to a frame whose content and control scanline have been made.
void corrupt(LinkFrame& link, const Fault& fault, DepthFormat format) {
    if (const int offset = fault_traits(fault.kind).control_offset; offset != FaultTraits::kNoOffset) {
        flip(link.control, offset, kByteBits);
        return;
    }
    switch (fault.kind) {
        case FaultKind::kControlByte:
            flip(link.control, fault.byte, fault.bits);
            break;
        case FaultKind::kShortLine:
            --link.last_line_pixels;
            break;
        case FaultKind::kLongLine:
            ++link.last_line_pixels;
            break;
        case FaultKind::kShortFrame:
            link.active_lines -= fault.lines;
            break;
        case FaultKind::kLongFrame:
            link.active_lines += fault.lines;
            break;
        case FaultKind::kPixelBits: {
            link.image = with_flipped_bits(link.image, fault, format);
            link.image_is_copy = true;
            break;
        }
        default:
            break;
    }
}

/// The slots that a scenario gives by display, as indices of rows.
std::vector<std::uint8_t> given_payload(const std::vector<int>& displays, const ViewportTable& table) {
    if (displays.empty()) return {};
    std::vector<int> slots;
    slots.reserve(displays.size());
    for (const int display : displays) {
        const auto row = std::find_if(table.begin(), table.end(),
                                      [display](const ViewportRow& one) { return one.dcomp == display; });
        slots.push_back(static_cast<int>(row - table.begin()));
    }
    return encode_slots(slots, table.size());
}

/// The payload of the entry's depth frames.
std::vector<std::uint8_t> host_payload(const Scenario& scenario, const Renderer& renderer,
                                       const RendererFrame& entry, const ValidatedTable& table) {
    if (entry.controls) return entry.controls->payload;
    if (entry.slots) return given_payload(*entry.slots, entry.table);
    return slot_payload(scenario.bus.arbitration, table, payload_room_bytes(renderer.image_width_pixels));
}

}  // namespace

SentSlots machine_slots(const BusConfig& bus, const ValidatedTable& table,
                        const std::vector<std::uint8_t>& payload) {
    if (bus.slot_table == SlotTableMaker::kHost) return sent_slots(bus.arbitration, table, payload);
    return {slots_of(bus.arbitration, table.rows), false};
}

SentSlots frame_slots(const Scenario& scenario, const Renderer& renderer, const RendererFrame& entry,
                      const ValidatedTable& table) {
    return machine_slots(scenario.bus, table, host_payload(scenario, renderer, entry, table));
}

ControlScanline control_content(const Scenario& scenario, const Renderer& renderer, std::uint32_t pair,
                                FrameKind frame) {
    const RendererFrame& entry = renderer.frame_of_pair(pair);
    ControlScanline content;
    content.kind = frame;
    content.frame_number = pair;
    if (frame == FrameKind::kColour) {
        content.table = entry.table;
    } else if (scenario.bus.slot_table == SlotTableMaker::kHost) {
        content.payload =
            host_payload(scenario, renderer, entry, validate_table(entry.table, scenario.limits(renderer)));
    }
    return content;
}

LinkFrame link_frame(const Scenario& scenario, int renderer_index, std::uint32_t pair, FrameKind frame) {
    const Renderer& renderer = scenario.renderers[static_cast<std::size_t>(renderer_index)];
    const DviTiming timing = renderer.timing();
    const std::vector<const Fault*> faults = corrupting_faults(scenario, renderer_index, pair, frame);
    const auto has = [&faults](FaultKind kind) {
        return std::any_of(faults.begin(), faults.end(),
                           [kind](const Fault* fault) { return fault->kind == kind; });
    };

    const std::uint32_t content_pair = pair + (has(FaultKind::kOtherPair) ? 1 : 0);
    ControlScanline content = control_content(scenario, renderer, content_pair, frame);
    if (has(FaultKind::kKind)) content.kind = kNoSuchKind;
    if (has(FaultKind::kNumber)) ++content.frame_number;

    const RendererFrame& entry = renderer.frame_of_pair(content_pair);
    LinkFrame link;
    if (entry.controls) {
        link.control = frame == FrameKind::kColour ? entry.controls->colour : entry.controls->depth;
    } else {
        link.control = encode_control_scanline(content, timing.active_pixels);
    }
    link.image = renderer.images[entry.image];
    link.active_lines = timing.active_lines;
    link.last_line_pixels = timing.active_pixels;
    link.faults = static_cast<std::int64_t>(faults.size());
    for (const Fault* fault : faults) corrupt(link, *fault, scenario.depth_format);
    return link;
}

LinkProgram::LinkProgram(const Scenario& scenario, int renderer)
    : scenario_(scenario),
      renderer_(scenario.renderers[static_cast<std::size_t>(renderer)]),
      renderer_index_(renderer) {}

void LinkProgram::reset() {
    next_pair_ = 0;
    pair_under_way_ = false;
    kind_ = FrameKind::kColour;
    send_again_ = false;
    clock_ppm_ = 0;
    character_faults_.clear();
    disturbance_ = TmdsDisturbance();
}

LinkProgram::Step LinkProgram::next(bool pair_requested) {
    while (true) {
        if (!pair_under_way_) {
            const bool may_send =
                scenario_.pacing == Pacing::kFreeRunning || (pair_requested && !all_pairs_sent());
            if (!may_send) return Step::kNothing;
            live_ = renderer_.is_live ? scenario_.live_pairs->next(renderer_index_, next_pair_)
                                      : LivePairs::Next::kPair;
            if (live_ == LivePairs::Next::kEnd) return Step::kNothing;
            begin_pair();
        } else if (live_ == LivePairs::Next::kSilence && delay_served_) {
            live_ = scenario_.live_pairs->next(renderer_index_, pair_);
            if (live_ == LivePairs::Next::kSilence) {
                silence_clocks_ = pair_clocks(renderer_);
                return Step::kSilence;
            }
        }
        if (send_again_) {
            send_again_ = false;
            ++injected_faults_;
            return Step::kFrame;
        }
        if (const Fault* const delay = fault_of(FaultKind::kDelay); delay != nullptr && !delay_served_) {
            delay_served_ = true;
            ++injected_faults_;
            const bool may_last = live_ == LivePairs::Next::kSilence;
            silence_clocks_ = pair_clocks(renderer_) * (may_last ? 1 : delay->delay_pairs);
            return Step::kSilence;
        }
        if (fault_of(FaultKind::kMissing) == nullptr) {
            frame_ = link_frame(scenario_, renderer_index_, pair_, kind_);
            injected_faults_ += frame_.faults;
            character_faults_ = character_faults_of_frame();
            return Step::kFrame;
        }
        ++injected_faults_;
        next_frame();
    }
}

void LinkProgram::end_frame() {
    if (!sent_again_ && fault_of(FaultKind::kRepeated) != nullptr) {
        send_again_ = true;
        sent_again_ = true;
        return;
    }
    next_frame();
}

/// Goes on to the next frame, after one that has been sent or is left out.
void LinkProgram::next_frame() {
    delay_served_ = false;
    sent_again_ = false;
    if (kind_ == FrameKind::kColour) {
        kind_ = FrameKind::kDepth;
    } else {
        pair_under_way_ = false;
    }
}

void LinkProgram::begin_pair() {
    pair_ = next_pair_++;
    pair_under_way_ = true;
    kind_ = FrameKind::kColour;
    delay_served_ = false;
    sent_again_ = false;
    for (const Fault& fault : scenario_.faults) {
        if (fault.kind != FaultKind::kDrift || fault.renderer != renderer_index_ || fault.pair != pair_) {
            continue;
        }
        clock_ppm_ = fault.ppm;
        ++injected_faults_;
    }
}

std::vector<const Fault*> LinkProgram::character_faults_of_frame() const {
    std::vector<const Fault*> faults;
    for (const Fault& fault : scenario_.faults) {
        if (fault_traits(fault.kind).location == FaultLocation::kCharacters &&
            fault.renderer == renderer_index_ && fault.pair == pair_ && fault.frame == kind_) {
            faults.push_back(&fault);
        }
    }
    return faults;
}

void LinkProgram::begin_clock(int line, int clock) {
    disturbance_.flips.fill(0);
    for (const Fault* const fault : character_faults_) {
        if (fault->at_line != line || fault->at_clock != clock) continue;
        const auto channel = static_cast<std::size_t>(fault->channel);
        ++injected_faults_;
        switch (fault->kind) {
            case FaultKind::kTmdsSlip:
                disturbance_.late_bits[channel] = static_cast<std::uint8_t>(fault->late_bits);
                break;
            case FaultKind::kTmdsSkew:
                disturbance_.late_characters[channel] = static_cast<std::uint8_t>(fault->late_characters);
                break;
            default:
                disturbance_.flips[channel] = static_cast<TmdsCharacter>(fault->bits);
                break;
        }
    }
}

const Fault* LinkProgram::fault_of(FaultKind kind) const {
    const auto found =
        std::find_if(scenario_.faults.begin(), scenario_.faults.end(), [&](const Fault& fault) {
            return fault.kind == kind && fault.renderer == renderer_index_ && fault.pair == pair_ &&
                   fault.frame == kind_;
        });
    return found == scenario_.faults.end() ? nullptr : &*found;
}

}  // namespace metabuffer

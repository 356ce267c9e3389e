#include "datapath/link/pair_follower.h"

namespace metabuffer {
namespace {

RejectCause cause_of(ScanlineDefect defect) {
    switch (defect) {
        case ScanlineDefect::kMagic:
            return RejectCause::kMagic;
        case ScanlineDefect::kVersion:
            return RejectCause::kVersion;
        case ScanlineDefect::kKind:
            return RejectCause::kKind;
        default:
            return RejectCause::kCrc;
    }
}

/// The earlier of two frame numbers, which count modulo 2^32.
std::uint32_t earlier(std::uint32_t a, std::uint32_t b) {
    return static_cast<std::int32_t>(a - b) < 0 ? a : b;
}

void lose_pair(std::uint32_t number, PairEvent& event) {
    event.pair_lost = true;
    event.lost_number = number;
}

}  // namespace

void PairFollower::reset() {
    const auto rejected = rejected_;
    *this = PairFollower{};
    rejected_ = rejected;
}

void PairFollower::begin_frame() {
    in_frame_ = true;
    colour_begun_ = false;
}

void PairFollower::end_control_scanline(const DecodedScanline& scanline, PairEvent& event) {
    if (!in_frame_) {
        return;
    }
    if (scanline.defect != ScanlineDefect::kNone) {
        reject(cause_of(scanline.defect), event);
        return;
    }
    kind_ = scanline.content.kind;
    if (kind_ == FrameKind::kColour) {
        begin_colour(scanline.content.frame_number, event);
    } else {
        begin_depth(scanline.content.frame_number, event);
    }
}

void PairFollower::begin_colour(std::uint32_t number, PairEvent& event) {
    if (expect_ == Expect::kDepth) {
        // The pair before this one never got its depth frame. If a colour frame is sent again, its pair begins again,
        // and no pair is lost.
        if (number == number_) {
            expect_ = Expect::kAnyColour;
        }
        reject(RejectCause::kPair, event);
        in_frame_ = true;
    }
    number_ = number;
    colour_begun_ = true;
    event.colour_start = true;
    event.number = number;
}

void PairFollower::begin_depth(std::uint32_t number, PairEvent& event) {
    if (expect_ == Expect::kDepth && number == number_) {
        return;
    }
    if (expect_ == Expect::kColour && number == number_) {
        reject(RejectCause::kPair, event);  // sent again after its pair, which is whole and stays so
        return;
    }
    // If the numbers of the two frames differ, the pair with the lower one is lost now.
    const std::uint32_t lost = expect_ == Expect::kDepth ? earlier(number, number_) : number;
    if (expect_ == Expect::kAnyColour) {
        in_frame_ = false;  // its colour frame has been rejected or was never seen
    } else {
        reject(RejectCause::kPair, event);
    }
    lose_pair(lost, event);
}

void PairFollower::reject_geometry(PairEvent& event) {
    if (in_frame_) {
        reject(RejectCause::kGeometry, event);
    }
}

void PairFollower::end_frame(bool whole, PairEvent& event) {
    if (!in_frame_) {
        return;
    }
    in_frame_ = false;
    if (!whole) {
        reject(RejectCause::kGeometry, event);
    } else if (kind_ == FrameKind::kColour) {
        expect_ = Expect::kDepth;
    } else {
        event.pair_good = true;
        event.number = number_;
        expect_ = Expect::kColour;
    }
}

/// Drops the frame under way, and the pair it belongs to.
void PairFollower::reject(RejectCause cause, PairEvent& event) {
    in_frame_ = false;
    ++rejected_[static_cast<std::size_t>(cause)];
    event.rejected = true;
    event.cause = cause;
    if (expect_ == Expect::kDepth || colour_begun_) {
        lose_pair(number_, event);
    }
    expect_ = Expect::kAnyColour;
}

}  // namespace metabuffer

#include "live/application_link.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "formats/pixel.h"

namespace metabuffer::live {
namespace {

std::size_t ring_bytes(const metabuffer_link_info& info) {
    return live_ring_bytes(info.image_width_pixels, info.image_height_pixels);
}

/// Messages are small, and an application that does not read has few to come.
bool send_now(int socket, const void* data, std::size_t bytes) {
    return send(socket, data, bytes, MSG_NOSIGNAL | MSG_DONTWAIT) == static_cast<ssize_t>(bytes);
}

/// The same with a descriptor beside it.
bool send_now(int socket, live_welcome& welcome, int descriptor) {
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
    iovec part{&welcome, sizeof welcome};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    cmsghdr* const carried = CMSG_FIRSTHDR(&message);
    carried->cmsg_level = SOL_SOCKET;
    carried->cmsg_type = SCM_RIGHTS;
    carried->cmsg_len = CMSG_LEN(sizeof(int));
    std::memcpy(CMSG_DATA(carried), &descriptor, sizeof descriptor);
    return sendmsg(socket, &message, MSG_NOSIGNAL | MSG_DONTWAIT) == static_cast<ssize_t>(sizeof welcome);
}

/// A welcome that says nothing yet.
live_welcome blank_welcome() {
    live_welcome welcome;
    std::memset(&welcome, 0, sizeof welcome);  // also what lies between its members
    welcome.magic = LIVE_MAGIC;
    welcome.version = LIVE_VERSION;
    return welcome;
}

}  // namespace

ApplicationLink::~ApplicationLink() {
    if (ring_ != nullptr) munmap(const_cast<std::uint32_t*>(ring_), ring_bytes(info_));
    if (ring_descriptor_ >= 0) close(ring_descriptor_);
    close(socket_);
}

bool ApplicationLink::is_of_this_user() const {
    ucred peer{};
    socklen_t bytes = sizeof peer;
    return getsockopt(socket_, SOL_SOCKET, SO_PEERCRED, &peer, &bytes) == 0 && peer.uid == geteuid();
}

bool ApplicationLink::receive() {
    // An application has at most a few messages under way; what floods the socket waits for the next call.
    constexpr std::size_t kMostBytes = 4096;
    std::array<char, kMostBytes> bytes{};
    if (!has_ended_) {
        const ssize_t received = recv(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT);
        if (received > 0) {
            input_.append(bytes.data(), static_cast<std::size_t>(received));
            read_messages();
        } else if (received == 0 || (errno != EAGAIN && errno != EINTR)) {
            has_ended_ = true;
        }
    }
    if (!fault_.empty()) has_ended_ = true;
    return !has_ended_;
}

void ApplicationLink::read_messages() {
    std::size_t at = 0;
    if (!hello_) {
        if (input_.size() < sizeof(live_hello)) return;
        hello_.emplace();
        std::memcpy(&*hello_, input_.data(), sizeof(live_hello));
        hello_->link_name[LIVE_NAME_BYTES - 1] = '\0';
        at = sizeof(live_hello);
    }
    for (; input_.size() - at >= sizeof(live_submission) && fault_.empty(); at += sizeof(live_submission)) {
        live_submission submission;
        std::memcpy(&submission, input_.data() + at, sizeof submission);
        const bool is_granted =
            submission.index < granted_.size() && granted_[submission.index] == submission.frame_number;
        if (!is_granted) {
            fault_ = "submits a pair that it was not granted";
            return;
        }
        granted_[submission.index].reset();
        submitted_.push_back(submission);
    }
    input_.erase(0, at);
}

void ApplicationLink::refuse(const std::string& message) const {
    live_welcome welcome = blank_welcome();
    std::copy_n(message.begin(), std::min<std::size_t>(message.size(), LIVE_MESSAGE_BYTES - 1),
                static_cast<char*>(welcome.message));
    send_now(socket_, &welcome, sizeof welcome);
}

bool ApplicationLink::accept(const metabuffer_link_info& info, std::uint32_t first_number) {
    info_ = info;
    const std::size_t bytes = ring_bytes(info);
    ring_descriptor_ = memfd_create("metabuffer-link", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    if (ring_descriptor_ < 0 || ftruncate(ring_descriptor_, static_cast<off_t>(bytes)) != 0 ||
        fcntl(ring_descriptor_, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0) {
        return false;
    }
    void* const ring = mmap(nullptr, bytes, PROT_READ, MAP_SHARED, ring_descriptor_, 0);
    if (ring == MAP_FAILED) return false;
    ring_ = static_cast<const std::uint32_t*>(ring);
    live_welcome welcome = blank_welcome();
    welcome.accepted = 1;
    welcome.info = info;
    if (!send_now(socket_, welcome, ring_descriptor_)) return false;
    next_number_ = first_number;
    for (std::uint32_t index = 0; index < LIVE_RING_PAIRS; ++index) grant(index, next_number_++);
    return true;
}

void ApplicationLink::grant(std::uint32_t index, std::uint32_t number) {
    granted_[index] = number;
    const live_grant message{index, number};
    // An application that has closed its end hears nothing, and what it submitted before is still to be read.
    send_now(socket_, &message, sizeof message);
}

ApplicationPair ApplicationLink::take(std::uint32_t least_number, bool with_pixels) {
    const live_submission& oldest = submitted_.front();
    const std::size_t words = live_frame_words(info_.image_width_pixels, info_.image_height_pixels);
    const auto line = static_cast<std::size_t>(info_.image_width_pixels);
    const std::uint32_t* const colour = ring_ + std::size_t{2} * oldest.index * words;
    const std::uint32_t* const depth = colour + words;
    ApplicationPair pair{oldest.frame_number, {colour, colour + line}, {depth, depth + line}, {}};
    for (std::vector<std::uint32_t>* const control : {&pair.colour_control, &pair.depth_control}) {
        for (std::uint32_t& word : *control) word &= kColourMask;
    }
    if (with_pixels) {
        const DepthFormat format =
            info_.depth_format == METABUFFER_Z24 ? DepthFormat::kZ24 : DepthFormat::kA8Z16;
        pair.pixels = PixelImage(info_.image_width_pixels, info_.image_height_pixels);
        for (std::size_t i = 0; i < pair.pixels.values.size(); ++i) {
            pair.pixels.values[i] = with_depth_half(with_colour_half(Pixel(), colour[line + i] & kColourMask),
                                                    depth[line + i] & kColourMask, format);
        }
    }
    drop(least_number);
    return pair;
}

void ApplicationLink::drop(std::uint32_t least_number) {
    const std::uint32_t index = submitted_.front().index;
    submitted_.pop_front();
    next_number_ = std::max(next_number_, least_number);
    grant(index, next_number_++);
}

}  // namespace metabuffer::live

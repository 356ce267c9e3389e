#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "application/live_protocol.h"
#include "formats/image.h"

namespace metabuffer::live {

/// What an application has submitted, as it was when it was taken over.
struct ApplicationPair {
    std::uint32_t number = 0;                   ///< that was granted
    std::vector<std::uint32_t> colour_control;  ///< scanline: link pixels, 24 bits each
    std::vector<std::uint32_t> depth_control;
    PixelImage pixels;
};

/// One connected application, by the protocol of application/live_protocol.h. Never blocks. The memory of the pairs is
/// this end's and sealed, so that the other end cannot take it away; what is in it may change at any time.
class ApplicationLink {
  public:
    /// Takes the socket over.
    explicit ApplicationLink(int socket) : socket_(socket) {}
    ~ApplicationLink();
    ApplicationLink(const ApplicationLink&) = delete;
    ApplicationLink& operator=(const ApplicationLink&) = delete;

    /// To poll for reading; -1 once the other end has closed.
    int descriptor() const { return has_ended_ ? -1 : socket_; }
    /// Of the user that runs this process.
    bool is_of_this_user() const;
    /// Reads what has come. False, with `fault` if the other end does not keep to the protocol, once it has ended.
    bool receive();
    const std::string& fault() const { return fault_; }

    /// What the application says first, once it has.
    const std::optional<live_hello>& hello() const { return hello_; }
    void refuse(const std::string& message) const;
    /// Makes the pairs and grants them, with numbers from `first_number` on. False if the system refuses.
    bool accept(const metabuffer_link_info& info, std::uint32_t first_number);

    /// Pairs submitted and not taken.
    std::size_t waiting() const { return submitted_.size(); }
    /// The number of the oldest of them.
    std::uint32_t oldest_number() const { return submitted_.front().frame_number; }
    /// Takes the oldest over, its pixels only if they are wanted, and grants its memory anew; the next number is at least
    /// `least_number`.
    ApplicationPair take(std::uint32_t least_number, bool with_pixels);
    /// The same without its pixels.
    void drop(std::uint32_t least_number);

  private:
    void read_messages();
    void grant(std::uint32_t index, std::uint32_t number);

    int socket_;
    bool has_ended_ = false;
    std::string fault_;
    std::string input_;
    std::optional<live_hello> hello_;
    metabuffer_link_info info_{};
    int ring_descriptor_ = -1;
    const std::uint32_t* ring_ = nullptr;
    std::array<std::optional<std::uint32_t>, LIVE_RING_PAIRS> granted_{};  ///< number, by pair of the ring
    std::deque<live_submission> submitted_;
    std::uint32_t next_number_ = 0;
};

}  // namespace metabuffer::live

#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "live/application_link.h"
#include "scenario/live_pairs.h"
#include "scenario/scenario.h"

namespace metabuffer::live {

struct LiveOptions {
    std::filesystem::path socket;  ///< at which it listens
    /// How long a link in lockstep waits for its application, in real time, before its pair is missing.
    std::chrono::duration<double> wait{10.0};
    bool keeps_pairs = false;  ///< in memory, to be recorded
    bool needs_pixels = true;  ///< false: only what control scanlines say
    bool real_time = false;    ///< free-running links keep to the clock on the wall
    int stop_descriptor = -1;  ///< readable when the wall is to end; -1: none
    /// Called with one line when an application comes, goes or is refused. May be empty.
    std::function<void(const std::string&)> on_event;
    /// Called now and then while a link waits. May be empty.
    std::function<void()> on_wait;
};

/// The wall's end of the connection to applications (application/metabuffer_host.h is theirs): listens at a Unix socket,
/// takes over the pairs that they submit, and adds them to the scenario as the links ask for them.
///
/// | condition | effect |
/// | --- | --- |
/// | lockstep, the link asks for a pair | model time stands still until it has come, or for `wait`: then it is missing |
/// | lockstep, no application has come to any link yet | it waits without limit |
/// | free-running, a pair begins | the newest that has come, else the last one again; before the first one, silence |
/// | the application has gone, what it submitted is sent | the link is silent, and another application may come |
/// | every application has gone, or stop_descriptor | no further frame begins |
/// | an application breaks the protocol | its link is closed, with one line |
///
/// An application must be of the same user; the socket has mode 0600.
class LiveWall final : public LivePairs {
  public:
    /// scenario: with live renderers; it grows, and must outlive the wall. Throws InputError if the socket cannot be made.
    LiveWall(Scenario& scenario, LiveOptions options);
    ~LiveWall() override;

    Next next(int renderer, std::uint32_t pair) override;
    /// A display has shown the frame, which was made of these pairs, by renderer (-1: none). Without keeps_pairs, earlier
    /// pairs give their memory back.
    void frame_shown(int frame, const std::vector<int>& pairs);
    /// No further frame begins.
    void end();

    /// Whether any pair has come.
    bool has_pairs() const;

  private:
    using Clock = std::chrono::steady_clock;

    struct Link {
        int renderer = 0;                              ///< index
        std::unique_ptr<ApplicationLink> application;  ///< null: none is there
        bool had_application = false;
        std::uint32_t begun = 0;    ///< pairs that the link has begun
        bool silent = false;        ///< before the pair begun last
        std::uint32_t taken = 0;    ///< pairs that came
        std::size_t silence = 0;    ///< index of the silence's fault
        std::size_t forgotten = 0;  ///< images that have given their memory back
    };

    bool is_gone(const Link& link) const { return !link.application && link.had_application; }
    bool all_gone() const;
    bool anybody_came() const;
    std::uint32_t pairs_to_come(const Link& link) const;
    void serve(std::chrono::duration<double> longest);
    void accept_application();
    Link* link_of(const std::string& name);
    std::string refusal(const live_hello& hello, const Link* link) const;
    void welcome(std::unique_ptr<ApplicationLink> application);
    void receive(Link& link);
    void close(Link& link, const std::string& why);
    Next next_in_lockstep(Link& link, std::uint32_t pair);
    Next next_free_running(Link& link, std::uint32_t pair);
    bool take(Link& link, std::uint32_t pair);
    bool add_pair(Link& link, std::uint32_t pair, ApplicationPair sent);
    Next missing(Link& link, std::uint32_t pair);
    Next silence(Link& link, std::uint32_t pair);
    RendererFrame& begin(Link& link, std::uint32_t pair, bool silent = false);
    Renderer& renderer_of(const Link& link) const {
        return scenario_.renderers[static_cast<std::size_t>(link.renderer)];
    }
    void report(const std::string& line) const;

    Scenario& scenario_;
    LiveOptions options_;
    int listener_ = -1;
    std::vector<Link> links_;
    std::vector<std::unique_ptr<ApplicationLink>> newcomers_;  ///< that have not said who they are
    int shown_ = -1;                                           ///< the newest frame on a display
    bool ended_ = false;
    Clock::time_point started_ = Clock::now();
};

}  // namespace metabuffer::live

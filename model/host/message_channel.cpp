#include "host/message_channel.h"

#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "host/errors.h"

namespace metabuffer {
namespace {

/// The first byte of a message on how work ended; the exception's text follows.
enum class Ending : char { kDone = 'd', kInputError = 'i', kOutputError = 'o', kOther = 'x' };

std::string message_of(Ending ending, std::string_view text = {}) {
    return std::string(1, static_cast<char>(ending)).append(text.substr(0, MessageChannel::kMostBytes - 1));
}

}  // namespace

MessageChannel::MessageChannel() {
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends_.data()) != 0) {
        throw InputError("metabuffer: no channel to another process: " +
                         std::generic_category().message(errno));
    }
}

MessageChannel::~MessageChannel() {
    for (const int end : ends_) {
        if (end >= 0) close(end);
    }
}

void MessageChannel::keep(std::size_t end) {
    own_ = end;
    close(std::exchange(ends_[1 - end], -1));
}

bool MessageChannel::send(std::string_view message) const {
    ssize_t sent = 0;
    do {
        sent = ::send(descriptor(), message.data(), message.size(), MSG_NOSIGNAL);
    } while (sent < 0 && errno == EINTR);
    return sent == static_cast<ssize_t>(message.size());
}

std::string MessageChannel::receive() const {
    std::string message(kMostBytes, '\0');
    ssize_t got = 0;
    // A process that ends with messages unread resets the connection. That is reported once, before the messages that
    // the process had sent, and those still come.
    do {
        got = recv(descriptor(), message.data(), message.size(), 0);
    } while (got < 0 && (errno == EINTR || errno == ECONNRESET));
    message.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
    return message;
}

void be_silent() {
    const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
    if (nowhere < 0) return;
    dup2(nowhere, STDERR_FILENO);
    close(nowhere);
}

std::string ending_of(const std::function<void()>& work) {
    try {
        work();
        return message_of(Ending::kDone);
    } catch (const InputError& error) {
        return message_of(Ending::kInputError, error.what());
    } catch (const OutputError& error) {
        return message_of(Ending::kOutputError, error.what());
    } catch (...) {
        return message_of(Ending::kOther);
    }
}

bool is_done(const std::string& ending) {
    if (ending.empty()) return false;
    const std::string text = ending.substr(1);
    switch (static_cast<Ending>(ending.front())) {
        case Ending::kDone:
            return true;
        case Ending::kInputError:
            throw InputError(text);
        case Ending::kOutputError:
            throw OutputError(text);
        case Ending::kOther:
            break;
    }
    return false;
}

}  // namespace metabuffer

// Runs the system on a chip under Verilator, joined to a network interface (TAP) of its own.
//
// Plusargs: +tap=<name> of the interface, which is made in the present network namespace; none
// without it. +loss=<per mille> of the pictures' packets, known by their UDP source port, that never
// reach it. +clocks=<number> ends the run. +rate: print the speed once a second. +answers: print for
// each command of GVCP and of Table I the clocks from its frame's first byte on the wire to the last
// one of the answer's frame. Standard input is the terminal's keyboard, standard output its screen;
// what the simulation itself says goes to standard error.

#include <fcntl.h>
#include <linux/if.h>
#include <linux/if_tun.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <memory>
#include <vector>

#include "Vsoc_bench.h"
#include "verilated.h"

namespace {

constexpr unsigned POLL_CLOCKS = 256;       // between two looks at the interface
constexpr unsigned GAP = 12;                // clocks between two frames, a byte each
constexpr size_t SHORTEST = 60;             // bytes of a frame without its check sequence
constexpr size_t LONGEST = 16384;           // likewise, of one that the interface gives
constexpr uint64_t RESET_CLOCKS = 16;
constexpr unsigned STREAM_PORT = 49152;     // of UDP, that pictures come from
constexpr unsigned GVCP_PORT = 3956;        // of UDP
constexpr unsigned TABLE_PORT = 4000;       // of TCP
constexpr unsigned UDP = 17, TCP = 6;
constexpr size_t PORT_AT = 14 + 20;         // where the source's stands in a frame
const uint8_t PREAMBLE[8] = {0x55, 0x55, 0x55, 0x55, 0x55, 0x55, 0x55, 0xD5};

volatile sig_atomic_t stopped = 0;

void stop(int) { stopped = 1; }

const char* text(int argc, char** argv, const char* name) {
    for (int k = 1; k < argc; ++k)
        if (!strncmp(argv[k], name, strlen(name))) return argv[k] + strlen(name);
    return nullptr;
}

uint64_t number(int argc, char** argv, const char* name, uint64_t otherwise) {
    const char* given = text(argc, argv, name);
    return given ? strtoull(given, nullptr, 10) : otherwise;
}

int open_tap(const char* name) {
    const int file = open("/dev/net/tun", O_RDWR | O_NONBLOCK);
    ifreq request{};
    request.ifr_flags = IFF_TAP | IFF_NO_PI;
    strncpy(request.ifr_name, name, IFNAMSIZ - 1);
    if (file < 0 || ioctl(file, TUNSETIFF, &request) < 0) {
        fprintf(stderr, "FAILED no network interface %s: %s\n", name, strerror(errno));
        exit(1);
    }
    return file;
}

// Ethernet's check sequence, of which each step takes a byte.
struct CheckSequence {
    uint32_t table[256];
    CheckSequence() {
        for (uint32_t k = 0; k < 256; ++k) {
            uint32_t value = k;
            for (int bit = 0; bit < 8; ++bit) value = value & 1 ? value >> 1 ^ 0xEDB88320 : value >> 1;
            table[k] = value;
        }
    }
    uint32_t of(const uint8_t* data, size_t size) const {
        uint32_t value = 0xFFFFFFFF;
        for (size_t k = 0; k < size; ++k) value = value >> 8 ^ table[(value ^ data[k]) & 0xFF];
        return ~value;
    }
};

unsigned number16(const uint8_t* data) { return data[0] << 8 | data[1]; }

// Clocks that commands wait for their answers. One command of each protocol is under way at a time.
class Answers {
public:
    explicit Answers(bool logged) : logged(logged) {}

    // A frame, without preamble and check sequence, of which the first byte came at that clock.
    void received(const uint8_t* data, uint64_t clock) {
        if (const int which = protocol(data, PORT_AT + 2); which >= 0) asked[which] = clock;
    }

    // A frame of which the last byte went at that clock; pictures: packets of them sent so far.
    void sent(const uint8_t* data, uint64_t clock, uint64_t pictures) {
        const int which = protocol(data, PORT_AT);
        if (which < 0 || !asked[which]) return;
        if (logged)
            fprintf(stderr, "ANSWER %s %llu %llu\n", which ? "table" : "gvcp",
                    (unsigned long long)(clock - asked[which]), (unsigned long long)pictures);
        asked[which] = 0;
    }

private:
    // 0: GVCP, 1: bytes of Table I, -1: neither.
    static int protocol(const uint8_t* data, size_t port_at) {
        if (number16(data + 12) != 0x0800) return -1;
        const unsigned port = number16(data + port_at);
        if (data[23] == UDP) return port == GVCP_PORT ? 0 : -1;
        const size_t headers = 20 + 4 * (data[PORT_AT + 12] >> 4);
        return data[23] == TCP && port == TABLE_PORT && number16(data + 16) > headers ? 1 : -1;
    }

    const bool logged;
    uint64_t asked[2] = {0, 0};
};

// The wire between the system's PHY and the interface.
class Wire {
public:
    Wire(Vsoc_bench& bench, int tap, unsigned loss, bool logged)
        : bench(bench), tap(tap), loss(loss), answers(logged) {}

    // After a rising edge of the clock: takes a byte that is sent, gives the next one.
    void clock(uint64_t clocks) {
        if (bench.tx_valid) {
            sent.push_back(bench.tx_data);
        } else if (!sent.empty()) {
            deliver(clocks);
            sent.clear();
        }
        if (next < received.size()) {
            bench.rx_valid = 1;
            bench.rx_data = received[next++];
        } else if (bench.rx_valid) {
            bench.rx_valid = 0;
            received.clear();
            next = 0;
            quiet_until = clocks + GAP;
        } else if (tap >= 0 && clocks >= quiet_until && clocks >= look) {
            look = clocks + POLL_CLOCKS;
            fetch(clocks);
        }
    }

    uint64_t frames_out = 0, frames_in = 0, lost = 0, broken = 0;

private:
    void deliver(uint64_t clocks) {
        const size_t around = sizeof PREAMBLE + 4;
        uint32_t given = 0;
        if (sent.size() >= SHORTEST + around)
            memcpy(&given, &sent[sent.size() - 4], 4);
        const uint8_t* data = sent.data() + sizeof PREAMBLE;
        if (sent.size() < SHORTEST + around || memcmp(sent.data(), PREAMBLE, sizeof PREAMBLE) ||
            given != check.of(data, sent.size() - around)) {
            ++broken;
            fprintf(stderr, "FRAME-ERROR a frame of %zu bytes is broken\n", sent.size());
            return;
        }
        ++frames_out;
        random = random * 6364136223846793005u + 1442695040888963407u;
        const bool picture = number16(data + 12) == 0x0800 && data[23] == UDP &&
                             number16(data + PORT_AT) == STREAM_PORT;
        pictures += picture;
        answers.sent(data, clocks, pictures);
        if (picture && (random >> 33) % 1000 < loss) {
            ++lost;
        } else if (tap >= 0 && write(tap, data, sent.size() - around) < 0 && errno != EIO) {
            ++lost;
        }
    }

    void fetch(uint64_t clocks) {
        uint8_t frame[LONGEST];
        ssize_t size = read(tap, frame, sizeof frame);
        if (size <= 0) return;
        if (size_t(size) < SHORTEST) {
            memset(frame + size, 0, SHORTEST - size);
            size = SHORTEST;
        }
        ++frames_in;
        answers.received(frame, clocks);
        received.assign(PREAMBLE, PREAMBLE + sizeof PREAMBLE);
        received.insert(received.end(), frame, frame + size);
        const uint32_t value = check.of(frame, size);
        for (int k = 0; k < 4; ++k) received.push_back(value >> 8 * k & 0xFF);
        look = 0;               // perhaps another one waits
    }

    Vsoc_bench& bench;
    const int tap;
    const unsigned loss;
    const CheckSequence check;
    Answers answers;
    uint64_t pictures = 0;      // packets of them that were sent
    std::vector<uint8_t> sent, received;
    size_t next = 0;
    uint64_t look = 0, quiet_until = 0, random = 1;
};

double cpu_seconds() { return double(clock()) / CLOCKS_PER_SEC; }

void report(uint64_t clocks, const Wire& wire) {
    const double seconds = cpu_seconds();
    fprintf(stderr, "RATE %llu clocks in %.2f CPU s, %.1f kHz; %llu frames out, %llu in, %llu lost, "
            "%llu broken\n", (unsigned long long)clocks, seconds, clocks / seconds / 1000,
            (unsigned long long)wire.frames_out, (unsigned long long)wire.frames_in,
            (unsigned long long)wire.lost, (unsigned long long)wire.broken);
}

}  // namespace

int main(int argc, char** argv) {
    signal(SIGTERM, stop);
    signal(SIGINT, stop);
    const auto context = std::make_unique<VerilatedContext>();
    context->commandArgs(argc, argv);
    const char* name = text(argc, argv, "+tap=");
    const uint64_t last = number(argc, argv, "+clocks=", ~0ull);
    const bool rate = text(argc, argv, "+rate") != nullptr;
    const auto bench = std::make_unique<Vsoc_bench>(context.get());
    Wire wire(*bench, name ? open_tap(name) : -1, number(argc, argv, "+loss=", 0),
              text(argc, argv, "+answers") != nullptr);
    if (name) fprintf(stderr, "TAP %s\n", name);
    const bool keyboard = isatty(STDIN_FILENO);
    double reported = 0;
    uint64_t clocks = 0;
    for (; !stopped && !context->gotFinish() && clocks < last; ++clocks) {
        bench->rst = clocks < RESET_CLOCKS;
        bench->extclk = 0;
        bench->clk = 1;
        bench->eval();
        if (bench->serial_valid && clocks > RESET_CLOCKS) {
            putchar(bench->serial_data);
            if (bench->serial_data == '\n') fflush(stdout);
        }
        wire.clock(clocks);
        bench->clk = 0;
        bench->extclk = 1;
        bench->eval();
        if (clocks % 4096 == 0 && keyboard) {
            pollfd key{STDIN_FILENO, POLLIN, 0};
            bench->terminal_valid = poll(&key, 1, 0) > 0 &&
                                    read(STDIN_FILENO, &bench->terminal_data, 1) == 1;
        } else {
            bench->terminal_valid = 0;
        }
        if (rate && clocks % 65536 == 0 && cpu_seconds() >= reported + 1) {
            reported = cpu_seconds();
            report(clocks, wire);
        }
    }
    report(clocks, wire);
    bench->final();
    return wire.broken != 0;
}

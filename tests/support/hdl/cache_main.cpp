// Frames of random windows through the tile cache, module `cache`, with a memory of random
// latency and waits, a source with gaps and a sink that stalls.
//
// No lens: the windows jump about, so that tiles replace each other all the time. Each frame has
// its own base, pitch, split, pattern of windows, and temper of memory, source and sink; some are
// cut short by a reset that the memory does not see. A byte of the memory is a hash of its
// address, so a sample of another tile, row or frame is a wrong one.
//
// Checked: every sample, the order of the windows and their flags. Every read command must be one of
// a direct-mapped cache of this size, in order. Commands that wait do not change. Windows are
// announced only if there is space, and come in their clock.
// Arguments: name=value, see main. Prints RESULT name value.
//
// Compiled in: NCDC_LANES, NCDC_DATA_WIDTH, NCDC_TILES, what an interpolation needs, the bits of a
// gain if raw samples have gains, and for each field of a request (I_) and a window (O_) its first bit in lane 0, with the bits of a lane: see
// cache_stress.py.

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "Vcache.h"
#include "verilated.h"

// Verilator's name of the port part__name.
#define PORT(part, name) part##___05F##name

namespace {

// A window are kCore samples in each direction and kMargin around them, of which the latter may lie
// outside the frame; a tile has kHeight rows, and kRows rows of tiles are in different banks.
constexpr int kCore = NCDC_CORE, kMargin = NCDC_MARGIN, kAfter = kCore + kMargin - 1;
constexpr int kHeight = NCDC_TILE_HEIGHT, kRows = NCDC_TILE_ROWS, kBanks = 2 * kRows;
constexpr int kLanes = NCDC_LANES, kWord = NCDC_DATA_WIDTH / 8, kSets = NCDC_TILES / kBanks;
constexpr int kFraction = NCDC_FRACTION_BITS;   // bits of fx and of fy

struct Random {
    std::uint64_t state;
    std::uint32_t next() {
        state ^= state << 13, state ^= state >> 7, state ^= state << 17;
        return static_cast<std::uint32_t>((state * 0x2545F4914F6CDD1D) >> 32);
    }
    std::uint32_t below(std::uint32_t n) { return static_cast<std::uint64_t>(next()) * n >> 32; }
    int between(int low, int high) { return low + static_cast<int>(below(high - low + 1)); }
    bool bernoulli(int of256) { return static_cast<int>(below(256)) < of256; }
};

std::uint8_t sample(std::uint32_t address) {
    std::uint32_t h = address * 0x9E3779B1u;
    h ^= h >> 15;
    return static_cast<std::uint8_t>(h * 0x85EBCA77u >> 24);
}

// Ports are numbers or, from 65 bits on, arrays of words.
template <class Port> std::uint32_t bits(const Port& port, int at, int width) {
    std::uint64_t value;
    if constexpr (std::is_integral_v<Port>) {
        value = static_cast<std::uint64_t>(port) >> at;
    } else {
        value = port[at / 32];
        if (at % 32 + width > 32) value |= static_cast<std::uint64_t>(port[at / 32 + 1]) << 32;
        value >>= at % 32;
    }
    return static_cast<std::uint32_t>(value & ((std::uint64_t{1} << width) - 1));
}

// Mixes a value into a hash.
void mix(std::uint64_t& hash, std::uint64_t value) {
    hash = (hash ^ value) * 0x9E3779B97F4A7C15;
    hash ^= hash >> 29;
}

template <class Port> void put(Port& port, int at, int width, std::uint32_t value) {
    for (int k = 0; k < width; k++) {
        const bool one = value >> k & 1;
        if constexpr (std::is_integral_v<Port>) {
            const Port mask = static_cast<Port>(Port{1} << (at + k));
            port = one ? port | mask : port & ~mask;
        } else {
            const std::uint32_t mask = 1u << ((at + k) % 32);
            std::uint32_t word = port[(at + k) / 32];
            port[(at + k) / 32] = one ? word | mask : word & ~mask;
        }
    }
}

struct Pixel { std::uint32_t x = 0, y = 0; bool blank = false; };
struct Group { Pixel lane[kLanes]; bool first, last; std::uint32_t number; };

struct Frame {
    std::uint32_t base, limit, pitch, split, phase, width, height, area_x, area_y, area_w, area_h;
    int pattern, blank, gap, stall, wait, latency, pause;
    std::uint32_t gains[3];     // of red, green and blue samples, in 256ths
    bool grey;                  // all samples have the gain of green
    std::uint64_t groups, reset_after;
};

[[noreturn]] void fail(const char* what, std::uint64_t clock) {
    std::printf("FAILED %s at clock %llu\n", what, static_cast<unsigned long long>(clock));
    std::exit(1);
}

}  // namespace

class Bench {
public:
    Bench(std::uint64_t seed, int resets, int frame_bits, bool far, int argc, char** argv)
        : random{seed * 0x9E3779B97F4A7C15 + 1}, resets(resets), frame_bits(frame_bits), far(far) {
        context->commandArgs(argc, argv);
        dut = std::make_unique<Vcache>(context.get());
        held.assign(kBanks * kSets, -1);
        dut->clk = 0, dut->rst = 1, dut->memory_rst = 0;
        dut->PORT(i, valid) = 0, dut->PORT(o, space) = 0;
        dut->PORT(bus0, waitrequest) = 0, dut->PORT(bus0, readdatavalid) = 0;
        for (int k = 0; k < 4; k++) clock();
        dut->rst = 0;
    }

    void frame(std::uint64_t limit) {
        choose(limit);
        dut->base = f.base, dut->pitch = f.pitch, dut->split = f.split;
        dut->limit = f.limit, dut->height = f.height;
#if NCDC_MARGIN
        dut->phase = f.phase;
#endif
#if NCDC_GAIN_BITS
        for (int k = 0; k < 3; k++) put(dut->balance, NCDC_GAIN_BITS * k, NCDC_GAIN_BITS, f.gains[k]);
        put(dut->balance, 3 * NCDC_GAIN_BITS, 3, f.phase | f.grey << 2);
#endif
        held.assign(kBanks * kSets, -1);
        sent = done = 0;
        x = f.area_x, y = f.area_y;
        while (done < f.groups) {
            step();
            if (f.reset_after && sent == f.reset_after) {
                reset();
                return;
            }
        }
        for (int k = 0; k < f.pause; k++) step();
        frames++;
    }

    std::uint64_t windows = 0, wrong = 0, clocks = 0, tiles = 0, frames = 0, reset_count = 0;
    std::uint64_t outputs = 0;      // a hash of those of all clocks

private:
    void choose_area() {
        // With a margin, a window may not leave the frame on both sides.
        const int least = kMargin ? 8 : kCore;
        f.width = random.bernoulli(32) ? random.between(least, 40) : random.between(least, 4096);
        f.height = random.bernoulli(32) ? random.between(least, 20) : random.between(least, 4096);
        f.pitch = (f.width + kWord - 1) / kWord * kWord + kWord * random.below(128 / kWord);
        int splits = 1;
        while (1 << splits < 2 * kSets) splits++;
        f.split = random.below(splits), f.phase = random.below(4);
        const int scale = 1 << random.between(2, 12);
        f.area_w = std::min<std::uint32_t>(f.width - (kCore - 1), scale);
        f.area_h = std::min<std::uint32_t>(f.height - (kCore - 1),
                                         std::max(1, scale >> random.below(6)));
        f.area_x = random.below(f.width - (kCore - 2) - f.area_w);
        f.area_y = random.below(f.height - (kCore - 2) - f.area_h);
        if (far) {
            f.area_x = f.width - (kCore - 1) - f.area_w;
            f.area_y = f.height - (kCore - 1) - f.area_h;
            if (random.bernoulli(64)) {
                f.area_x = f.area_y = 0;
                f.area_w = f.width - (kCore - 1), f.area_h = f.height - (kCore - 1);
            }
        }
    }

    void choose(std::uint64_t limit) {
        // Half of the frames are where the one before was, at another base.
        if (f.groups == 0 || random.bernoulli(128)) choose_area();
        // A frame of 4096 rows of at most 4220 bytes is below the end of all addresses.
        f.base = kWord * random.below((far ? (1u << 28) - (1u << 21) : 1u << 26) * (16 / kWord));
        // Half of the buffers end with the frame: no byte is read after those that a tile of 16
        // columns may have beyond a row.
        f.limit = f.base + f.pitch * f.height + (f.pitch % 16 ? 16 - kWord : 0)
                  + (random.bernoulli(128) ? 0 : 4 * f.pitch);
        f.pattern = random.below(far ? 5 : 4);
        f.blank = random.bernoulli(64) ? random.below(256) : 20;
        f.gap = random.bernoulli(128) ? 0 : random.below(200);
        f.stall = random.bernoulli(128) ? 0 : random.below(200);
        f.wait = random.bernoulli(128) ? 0 : random.below(220);
        f.latency = random.bernoulli(64) ? 1 : random.between(1, 100);
        f.pause = random.bernoulli(128) ? 0 : random.below(40);
        f.groups = std::min<std::uint64_t>(limit, random.between(1, 1 << random.between(3, frame_bits)));
        for (std::uint32_t& gain : f.gains) gain = random.below(NCDC_GAIN_BITS ? 1 << NCDC_GAIN_BITS : 1);
        f.grey = random.bernoulli(32);
        f.reset_after = random.bernoulli(resets)
                            ? random.between(1, static_cast<int>(f.groups)) : 0;
    }

    // 0: anywhere in the area, 1: a walk, 2: along rows, 3: along columns, 4: to and fro by a power
    // of two, with jumps in all.
    Group next_group() {
        Group group;
        for (Pixel& p : group.lane) {
            const bool jump = f.pattern == 0 || random.bernoulli(4);
            if (jump) {
                x = f.area_x + random.below(f.area_w), y = f.area_y + random.below(f.area_h);
            } else if (f.pattern == 1) {
                x += random.between(-3, 3), y += random.between(-1, 1);
            } else if (f.pattern == 2) {
                x += random.between(0, 2), y += random.bernoulli(8);
                if (x >= f.area_x + f.area_w) x = f.area_x, y++;
            } else if (f.pattern == 4) {
                (random.bernoulli(128) ? x : y) ^= 1u << random.between(3, 11);
            } else {
                y += random.between(0, 2), x += random.bernoulli(8);
                if (y >= f.area_y + f.area_h) y = f.area_y, x++;
            }
            if (x < f.area_x || x >= f.area_x + f.area_w) x = f.area_x;
            if (y < f.area_y || y >= f.area_y + f.area_h) y = f.area_y;
            p.x = x, p.y = y, p.blank = random.bernoulli(f.blank);
        }
        group.first = sent == 0;
        group.last = sent == f.groups - 1;
        group.number = counter++;
        ask(group, 0, kLanes);
        return group;
    }

    // A fraction that differs from the number of its group in most bits.
    static std::uint64_t scrambled(std::uint64_t number) { return number * 0x9E3779B1 >> 7; }

    // First and last sample in the frame of the window of a coordinate.
    static std::uint32_t first(std::uint32_t position) {
        return position < kMargin ? 0 : position - kMargin;
    }

    static std::uint32_t last(std::uint32_t position, std::uint32_t size) {
        return kMargin ? std::min(position + kAfter, size - 1) : position + kAfter;
    }

    // Mirrored about the first or last column, or row.
    static std::uint32_t inside(int position, int size) {
        if (position < 0) return -position;
        return kMargin && position >= size ? 2 * (size - 1) - position : position;
    }

    // The sample of the frame as a window must have it.
    std::uint32_t balanced(std::uint32_t row, std::uint32_t column) const {
        const std::uint32_t raw = sample(f.base + row * f.pitch + column);
#if NCDC_GAIN_BITS
        const bool red_column = !((column ^ f.phase) & 1), red_row = !((row ^ f.phase >> 1) & 1);
        const int colour = f.grey || red_column != red_row ? 1 : red_row ? 0 : 2;
        return std::min(255u, raw * f.gains[colour] + 128 >> 8);
#else
        return raw;
#endif
    }

    // Steps of row, or column, k of a window from its core.
    static int away(int k) { return std::max({kMargin - k, k - kAfter, 0}); }

    // What the cache must ask for: a box of NCDC_BOX_WORDS words by NCDC_BOX_ROWS rows, of no more
    // than kRows rows of tiles, is one look-up; a group that needs more is cut in halves.
    void ask(const Group& group, int from, int count) {
        std::uint32_t x0 = ~0u, x1 = 0, y0 = ~0u, y1 = 0;
        bool any = false;
        for (int k = from; k < from + count; k++) {
            const Pixel& p = group.lane[k];
            if (p.blank) continue;
            any = true;
            x0 = std::min(x0, first(p.x)), x1 = std::max(x1, last(p.x, f.width));
            y0 = std::min(y0, first(p.y)), y1 = std::max(y1, last(p.y, f.height));
        }
        if (!any) return;
        if (count > 1 && (x1 / NCDC_BOX_WORD >= x0 / NCDC_BOX_WORD + NCDC_BOX_WORDS
                          || y1 >= y0 + NCDC_BOX_ROWS || y1 / kHeight >= y0 / kHeight + kRows)) {
            ask(group, from, count / 2);
            ask(group, from + count / 2, count / 2);
            return;
        }
        for (std::uint32_t bank = 0; bank < kBanks; bank++) {
            const std::uint32_t tx = (x0 >> 4) + (((x0 >> 4) ^ bank) & 1);
            const std::uint32_t top = y0 / kHeight;
            const std::uint32_t ty = top + (bank / 2 + kRows - top % kRows) % kRows;
            if (tx > x1 >> 4 || ty > y1 / kHeight) continue;
            const std::uint32_t kx = 1u << f.split, ky = kSets >> f.split;
            const std::uint32_t slot = bank * kSets + (ty / kRows % ky) * kx + tx / 2 % kx;
            const std::int64_t tile = static_cast<std::int64_t>(ty) << 16 | tx;
            if (held[slot] == tile) continue;
            held[slot] = tile;
            tiles++;
            for (std::uint32_t row = 0; row < kHeight; row++) {
                const std::uint32_t at = f.base + (kHeight * ty + row) * f.pitch + 16 * tx;
                expected.push_back(at + 16 > f.limit ? f.base : at);
            }
        }
    }

    void step() {
        // Source.
        if (!offered && sent < f.groups && !random.bernoulli(f.gap)) {
            current = next_group();
            offered = true;
            for (int k = 0; k < kLanes; k++) {
                const Pixel& p = current.lane[k];
                const int at = k * I_LANE;
                put(dut->PORT(i, payload), I_X0 + at, 12, p.x);
                put(dut->PORT(i, payload), I_Y0 + at, 12, p.y);
                put(dut->PORT(i, payload), I_FX + at, kFraction, current.number + k);
                put(dut->PORT(i, payload), I_FY + at, kFraction, scrambled(current.number) ^ k);
                put(dut->PORT(i, payload), I_BLANK + at, 1, p.blank);
#if NCDC_MARGIN
                put(dut->PORT(i, payload), I_EDGE_X + at, 3, edge(p.x, f.width));
                put(dut->PORT(i, payload), I_EDGE_Y + at, 3, edge(p.y, f.height));
#endif
            }
            put(dut->PORT(i, payload), I_FIRST, 1, current.first);
            put(dut->PORT(i, payload), I_LAST, 1, current.last);
        }
        dut->PORT(i, valid) = offered;
        dut->PORT(o, space) = !random.bernoulli(f.stall);
        clock();
    }

    // One clock of everything but the source.
    void clock() {
        // Memory.
        const bool answer = !due.empty() && due.front().ready <= clocks
                            && !random.bernoulli(f.wait / 4);
        dut->PORT(bus0, readdatavalid) = answer;
        for (int k = 0; k < kWord; k++)
            put(dut->PORT(bus0, readdata), 8 * k, 8,
                answer ? sample(due.front().address + k) : random.next() & 255);
        if (answer) due.pop_front();
        dut->PORT(bus0, waitrequest) = random.bernoulli(f.wait);
        dut->eval();

        if (dut->PORT(bus0, read)) {
            if (command_held && dut->PORT(bus0, address) != command)
                fail("command changed", clocks);
            command = dut->PORT(bus0, address);
            command_held = dut->PORT(bus0, waitrequest);
            if (!command_held) accept();
        } else if (command_held && !dut->memory_rst) {
            fail("command withdrawn", clocks);
        }
        if (dut->memory_rst) {
            // Reset as well, it forgets what it has accepted.
            command_held = false;
            left_over = -1;
            due.clear();
        }
        listen();
        if (dut->outside && !dut->rst) fail("a row of the frame taken for one outside", clocks);
        if (!dut->rst) take();
        if (clocks - moved > 100000) fail("hang", clocks);

        dut->clk = 1;
        dut->eval();
        dut->clk = 0;
        dut->eval();
        clocks++;
    }

    // All outputs that mean something in this clock.
    void listen() {
        mix(outputs, dut->PORT(i, ready) | dut->PORT(o, issue) << 1 | dut->PORT(o, valid) << 2
            | dut->outside << 3 | dut->empty << 4 | dut->fetched << 5 | dut->waiting << 6
            | dut->PORT(bus0, read) << 7 | dut->stalls << 8);
        if (dut->PORT(bus0, read)) mix(outputs, dut->PORT(bus0, address));
    }

    void accept() {
        if (dut->PORT(bus0, burstcount) != 16 / kWord) fail("burstcount", clocks);
        if (left_over >= 0 && command == static_cast<std::uint64_t>(left_over)) {
            left_over = -1;
        } else {
            left_over = -1;
            if (expected.empty() || expected.front() != command)
                fail("read of a wrong tile", clocks);
            expected.pop_front();
        }
        const std::uint64_t ready = clocks + random.between(1, f.latency);
        for (int k = 0; k < 16 / kWord; k++) due.push_back({command + k * kWord, ready});
    }

    void take() {
        if (offered && dut->PORT(i, ready)) {
            offered = false;
            sent++;
            flying.push_back(current);
            moved = clocks;
        }
        if (dut->PORT(o, issue) && !space) fail("window announced without space", clocks);
        space = dut->PORT(o, space);
        issued = issued << 1 | dut->PORT(o, issue);
        const bool valid = dut->PORT(o, valid);
        if ((issued >> NCDC_WINDOW_LATENCY & 1) != valid) fail("window at another time", clocks);
        if (!valid) return;
        std::memcpy(&window, &dut->PORT(o, payload), sizeof window);
        if (flying.empty()) fail("unrequested window", clocks);
        const Group& group = flying.front();
        bool right = bits(window, O_FIRST, 1) == group.first
                     && bits(window, O_LAST, 1) == group.last;
        for (int k = 0; k < kLanes; k++) {
            const Pixel& p = group.lane[k];
            const int at = k * O_LANE;
            const std::uint32_t mask = (1u << kFraction) - 1;
            right &= bits(window, O_FX + at, kFraction) == ((group.number + k) & mask);
            right &= bits(window, O_FY + at, kFraction)
                     == ((scrambled(group.number) ^ k) & mask);
            right &= bits(window, O_BLANK + at, 1) == p.blank;
            if (p.blank) continue;
#if NCDC_MARGIN
            // Even columns are even ones of the frame; where they meet even rows, samples are green.
            const bool left = p.x & 1, up = !((p.y ^ f.phase ^ f.phase >> 1) & 1);
            right &= bits(window, O_FLIPPED + at, 2) == (left | up << 1);
#else
            const bool left = false, up = false;
            right &= bits(window, O_ODD_COLUMN + at, 1) == (p.x & 1);
            right &= bits(window, O_ODD_ROW + at, 1) == (p.y & 1);
#endif
            int n = 0;
            for (int j = 0; j < kCore + 2 * kMargin; j++) {
                for (int i = 0; i < kCore + 2 * kMargin; i++) {
                    if (away(j) + away(i) > kMargin) continue;
                    const int below = static_cast<int>(p.y) + (up ? kAfter - j : j - kMargin);
                    const int across = static_cast<int>(p.x) + (left ? kAfter - i : i - kMargin);
                    const std::uint32_t row = inside(below, f.height);
                    const std::uint32_t column = inside(across, f.width);
                    right &= bits(window, O_SAMPLES + at + 8 * n++, 8) == balanced(row, column);
                }
            }
        }
        windows += kLanes;
        wrong += right ? 0 : kLanes;
        done++;
        moved = clocks;
        flying.pop_front();
    }

    // Samples outside in the low two bits; the third: they are after the last one.
    static std::uint32_t edge(int position, int size) {
        const int before = kMargin - position, after = position + kAfter - (size - 1);
        return after > 0 ? after | 4 : std::max(before, 0);
    }

    // The memory goes on, and what it owes must not reach the next frame; or it is reset as well.
    void reset() {
        dut->rst = 1;
        dut->memory_rst = random.bernoulli(128);
        dut->PORT(i, valid) = 0;
        const int length = random.between(1, 60);
        clock();
        // A command that is on the bus by now stays there.
        left_over = dut->memory_rst || expected.empty() ? -1 : static_cast<std::int64_t>(expected.front());
        expected.clear();
        for (int k = 1; k < length; k++) clock();
        dut->rst = dut->memory_rst = 0;
        flying.clear();
        offered = false, space = true, issued = 0;
        moved = clocks;
        reset_count++;
    }

    struct Word { std::uint32_t address; std::uint64_t ready; };

    const std::unique_ptr<VerilatedContext> context = std::make_unique<VerilatedContext>();
    std::unique_ptr<Vcache> dut;
    Random random;
    int resets, frame_bits;
    bool far;
    Frame f{};
    Group current{};
    bool offered = false, command_held = false;
    bool space = true;          // there was space for a window a clock ago
    std::uint64_t issued = 0;   // windows announced, a bit for each clock, the last one lowest
    std::uint32_t x = 0, y = 0, counter = 0, command = 0;
    std::uint64_t sent = 0, done = 0, moved = 0;
    std::int64_t left_over = -1;
    std::vector<std::int64_t> held;
    std::deque<std::uint32_t> expected;
    std::deque<Word> due;
    std::deque<Group> flying;
    std::remove_reference_t<decltype(std::declval<Vcache>().PORT(o, payload))> window{};
};

int main(int argc, char** argv) {
    std::uint64_t seed = 1, groups = 100000, resets = 0, frame_bits = 12, far = 0;
    for (int k = 1; k < argc; k++) {
        const std::string text = argv[k];
        const std::uint64_t value = std::strtoull(text.c_str() + text.find('=') + 1, nullptr, 10);
        if (text.rfind("+seed=", 0) == 0) seed = value;
        if (text.rfind("+groups=", 0) == 0) groups = value;
        if (text.rfind("+resets=", 0) == 0) resets = value;      // frames of 256 that are cut short
        if (text.rfind("+frame_bits=", 0) == 0) frame_bits = value;  // log2 of a frame's most groups
        if (text.rfind("+far=", 0) == 0) far = value;   // windows at the end of frames anywhere
    }
    Bench bench(seed, static_cast<int>(resets), static_cast<int>(frame_bits), far, argc, argv);
    while (bench.windows < groups * kLanes) bench.frame(groups - bench.windows / kLanes);
    const std::pair<const char*, std::uint64_t> results[] = {
        {"windows", bench.windows}, {"wrong", bench.wrong}, {"total_clocks", bench.clocks},
        {"tiles", bench.tiles}, {"frames", bench.frames}, {"resets", bench.reset_count},
        {"outputs", bench.outputs}};
    for (const auto& [name, value] : results)
        std::printf("RESULT %s %llu\n", name, static_cast<unsigned long long>(value));
    return 0;
}

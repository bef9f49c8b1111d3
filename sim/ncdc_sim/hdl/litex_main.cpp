// Runs a LiteX system with the corrector as a module under Verilator: a master on its bus, as a
// bridge to a PC would be, and a sink of its video.
//
// The file program.txt, a line per operation, numbers in hex:
//   w address value     write a word
//   r address           read one; prints READ address value
//   l address           write the file source.bin there
//   d address bytes     write what is there into the file output.bin
//   p clocks            let so many go by
//   x clocks            reset the whole system for so many
//   i                   wait for the interrupt; prints IRQ clocks, from the last write's answer
//   m address words     until the interrupt, read one of so many words from there on after the
//                       other, at random; prints WAITS number, clocks of all, maximum of one
// Plusargs: +clocks=<number> at most. +sink=<of 256 clocks> in which the sink of the video is ready.
//
// Pixels, red first, are written into the file video.bin. Lines: FIRST and LAST pixel, as numbers
// from 0; VIDEO-ERROR rule clock; BUS-ERROR address; FAILED; CLOCKS number at the end.

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <memory>
#include <vector>

#include "Vncdc_litex.h"
#include "verilated.h"
#if VM_COVERAGE
#include "verilated_cov.h"
#endif

namespace {

uint64_t number(int argc, char** argv, const char* name, uint64_t otherwise) {
    for (int k = 1; k < argc; ++k)
        if (!strncmp(argv[k], name, strlen(name)))
            return strtoull(argv[k] + strlen(name), nullptr, 10);
    return otherwise;
}

struct Access {
    char kind;          // of the operation that it belongs to
    uint32_t address, value;
};

// The program as accesses, one after the other; a word of a dump is one.
std::deque<Access> program() {
    std::deque<Access> accesses;
    FILE* file = fopen("program.txt", "r");
    char kind;
    while (file && fscanf(file, " %c", &kind) == 1) {
        uint32_t address = 0, value = 0;
        if (kind == 'w' || kind == 'd' || kind == 'm') {
            if (fscanf(file, "%x %x", &address, &value) != 2) break;
        } else if (kind != 'i' && fscanf(file, "%x", &address) != 1) {
            break;
        }
        if (kind == 'l') {
            FILE* source = fopen("source.bin", "rb");
            while (source && fread(&value, 4, 1, source) == 1) {
                accesses.push_back({'w', address, value});
                address += 4;
            }
            if (source) fclose(source);
        } else if (kind == 'd') {
            for (uint32_t k = 0; k < value; k += 4) accesses.push_back({'d', address + k, 0});
        } else {
            accesses.push_back({kind, address, value});
        }
    }
    if (file) fclose(file);
    return accesses;
}

class Master {
public:
    explicit Master(Vncdc_litex& soc) : soc(soc), left(program()), output(fopen("output.bin", "wb")) {}
    ~Master() { fclose(output); }

    bool ended() const { return left.empty(); }
    bool resets() const { return !left.empty() && left.front().kind == 'x'; }

    // Before a rising edge: what the bus says in this clock.
    void look(uint64_t clock) {
        if (left.empty()) return;
        const Access& now = left.front();
        if (now.kind == 'p' || now.kind == 'x') {
            if (++passed < now.address) return;
            passed = 0;
        } else if (now.kind == 'm') {
            if (!word_came() || !soc.frame_irq) return;
            printf("WAITS %llu %llu %llu\n", (unsigned long long)words,
                   (unsigned long long)total, (unsigned long long)longest);
            words = total = longest = offset = 0;
        } else if (now.kind == 'i') {
            if (!soc.frame_irq) return;
            printf("IRQ %llu\n", (unsigned long long)(clock - written));
        } else {
            if (soc.host_err) printf("BUS-ERROR %08x\n", now.address);
            if (!soc.host_cyc || !(soc.host_ack || soc.host_err)) return;
            if (now.kind == 'w') written = clock;
            if (now.kind == 'r') printf("READ %08x %08x\n", now.address, soc.host_dat_r);
            if (now.kind == 'd') fwrite(&soc.host_dat_r, 4, 1, output);
        }
        left.pop_front();
    }

    // After it: what is asked in the next one.
    void drive() {
        const bool asks = !left.empty() && !strchr("ipx", left.front().kind);
        soc.host_cyc = soc.host_stb = asks;
        if (!asks) return;
        soc.host_adr = (left.front().address >> 2) + offset;
        soc.host_we = left.front().kind == 'w';
        soc.host_dat_w = left.front().value;
        soc.host_sel = 15;
    }

private:
    // Whether a word that is read at random has come, in the clock that is looked at; another one
    // is asked for then. Its clocks count from the first one in which it was asked for.
    bool word_came() {
        ++waited;
        if (!soc.host_ack && !soc.host_err) return false;
        if (soc.host_err) printf("BUS-ERROR %08x\n", left.front().address + 4 * offset);
        total += waited;
        longest = std::max(longest, waited);
        ++words;
        waited = 0;
        random = random * 6364136223846793005u + 1442695040888963407u;
        offset = (random >> 33) % left.front().value;
        return true;
    }

    Vncdc_litex& soc;
    std::deque<Access> left;
    FILE* output;
    uint64_t written = 0, passed = 0;
    // Of words that are read at random: clocks of the present one, of all, of the slowest; number.
    uint64_t waited = 0, total = 0, longest = 0, words = 0, random = 1;
    uint32_t offset = 0;        // of the present one, in words
};

class Sink {
public:
    Sink(Vncdc_litex& soc, unsigned probability)
        : soc(soc), probability(probability), video(fopen("video.bin", "wb")) {}
    ~Sink() { fclose(video); }

    void look(uint64_t clock) {
        const uint32_t now = soc.video_r | soc.video_g << 8 | soc.video_b << 16 |
                             soc.video_first << 24 | soc.video_last << 25;
        if (soc.sys_rst) {
            waits = false;
            return;
        }
        if (waits && (!soc.video_valid || now != before)) violation("held", clock);
        if (soc.video_valid != soc.video_de) violation("de", clock);
        if (soc.video_hsync || soc.video_vsync) violation("sync", clock);
        if (soc.video_valid && soc.video_ready) {
            if (soc.video_first) printf("FIRST %llu\n", (unsigned long long)pixels);
            if (soc.video_last) printf("LAST %llu\n", (unsigned long long)pixels);
            fwrite(&now, 3, 1, video);
            ++pixels;
        }
        waits = soc.video_valid && !soc.video_ready;
        before = now;
    }

    void drive() {
        random = random * 6364136223846793005u + 1442695040888963407u;
        soc.video_ready = (random >> 40 & 255) < probability;
    }

private:
    static void violation(const char* rule, uint64_t clock) {
        printf("VIDEO-ERROR %s %llu\n", rule, (unsigned long long)clock);
    }

    Vncdc_litex& soc;
    const unsigned probability;
    FILE* video;
    uint64_t random = 1, pixels = 0;
    uint32_t before = 0;
    bool waits = false;
};

}  // namespace

int main(int argc, char** argv) {
    const auto context = std::make_unique<VerilatedContext>();
    context->commandArgs(argc, argv);
    const uint64_t last = number(argc, argv, "+clocks=", 1000000);
    const auto soc = std::make_unique<Vncdc_litex>(context.get());
    uint64_t clock = 0;
    {
        Master master(*soc);
        Sink sink(*soc, number(argc, argv, "+sink=", 256));
        for (; clock < last && !master.ended(); ++clock) {
            soc->sys_rst = clock < 16 || master.resets();
            soc->sys_clk = 0;
            soc->eval();
            if (clock > 16) {
                master.look(clock);
                sink.look(clock);
            }
            soc->sys_clk = 1;
            soc->eval();
            if (clock >= 16) {
                master.drive();
                sink.drive();
            }
        }
        if (!master.ended()) printf("FAILED the program has not ended\n");
        printf("CLOCKS %llu\n", (unsigned long long)clock);
    }
    soc->final();
#if VM_COVERAGE
    context->coveragep()->write(getenv("NCDC_COVERAGE"));
#endif
    return 0;
}

# NCDC from Intel's System Console, over a JTAG host that reaches registers and memory:
#
#     system-console --cli
#     % source ncdc_console.tcl
#     % ncdc::connect
#     % ncdc::load wide
#     % ncdc::correct frame.raw picture.ppm
#
# ncdc_console_data.tcl, in the same folder, has the registers and the lenses of this corrector.

namespace eval ncdc {
    variable service ""         ;# the JTAG host, claimed
    variable registers          ;# address of the corrector's registers, in the host's map
    variable memory             ;# offset of the host's memory addresses to the corrector's
    variable lens ""            ;# name of the lens that was loaded last
    source [file join [file dirname [info script]] ncdc_console_data.tcl]
}

# Claim the host number `index`, and look for the corrector.
proc ncdc::connect {{at 0x10000000} {offset 0} {index 0}} {
    variable service
    variable registers $at
    variable memory $offset
    variable id
    variable version
    set hosts [get_service_paths master]
    if {$index >= [llength $hosts]} {
        error "host $index is requested, System Console finds [llength $hosts]"
    }
    if {$service eq ""} {
        set service [claim_service master [lindex $hosts $index] ncdc]
    }
    if {[get ID] != $id} {
        error [format "ID reads 0x%08x at 0x%08x, 0x%08x is needed" [get ID] $at $id]
    }
    set found [field CAPABILITIES VERSION]
    if {$found != $version} {
        error "the corrector's registers are of version $found, this script is for $version"
    }
    return "[get NEURONS] neurons, digest [format %08x [get DIGEST]]"
}

# Release the host.
proc ncdc::disconnect {} {
    variable service
    close_service master $service
    set service ""
}

# The register `name`.
proc ncdc::get {name} {
    variable service
    variable registers
    variable offsets
    return [expr {[lindex [master_read_32 $service \
        [format 0x%08x [expr {$registers + [dict get $offsets $name]}]] 1] 0] & 0xffffffff}]
}

# Write the register `name`, or the word at an offset.
proc ncdc::put {name value} {
    variable service
    variable registers
    variable offsets
    set offset [expr {[dict exists $offsets $name] ? [dict get $offsets $name] : $name}]
    master_write_32 $service [format 0x%08x [expr {$registers + $offset}]] \
        [format 0x%08x [expr {$value & 0xffffffff}]]
}

# The part `flag` of the register `name`, as a number.
proc ncdc::field {name flag} {
    variable flags
    set mask [dict get $flags ${name}_$flag]
    return [expr {([get $name] & $mask) / ($mask & -$mask)}]
}

proc ncdc::flag {name flag} {
    variable flags
    return [dict get $flags ${name}_$flag]
}

# Load the lens `name` for the next frame and all later ones.
proc ncdc::load {name} {
    variable lenses
    variable lens
    variable valid_rows
    if {![dict exists $lenses $name]} {
        error "the lens is $name, there are [join [dict keys $lenses] {, }]"
    }
    set one [dict get $lenses $name]
    if {[field CAPABILITIES FIXED_LENS]} {
        set found [format %08x [get DIGEST]]
        set digest [string range [dict get $one digest] 0 7]
        if {$found ne $digest} {
            error "the lens $name has the digest $digest, the corrector has the fixed lens $found"
        }
        set lens $name
        return
    }
    if {[dict get $one neurons] != [get NEURONS]} {
        error "the lens $name has [dict get $one neurons] hidden neurons, the corrector [get NEURONS]"
    }
    if {!([get CAPABILITIES] & [dict get $one interpolation])} {
        error "the lens $name is for another interpolation than the corrector's"
    }
    if {[dict get $one width] > [field LARGEST WIDTH] || [dict get $one height] > [field LARGEST HEIGHT]
            || [dict get $one width] % [field CAPABILITIES LANES]} {
        error "the lens $name makes [dict get $one width]x[dict get $one height] pixels, the corrector\
            up to [field LARGEST WIDTH]x[field LARGEST HEIGHT] in rows that are a multiple of\
            [field CAPABILITIES LANES]"
    }
    free
    set bank [expr {![field STATUS BANK]}]
    dict for {register value} [dict get $one values] {
        put $register $value
    }
    put VALID_WINDOW $bank
    set offset $valid_rows
    foreach span [dict get $one valid_rows] {
        put $offset $span
        incr offset 4
    }
    put VALID_BANK $bank
    taken
    set lens $name
    return
}

# Correct the raw frame in a file, and write the picture as PPM. The frames are in memory at
# `source` and `target`; without `target` the picture follows the raw frame.
proc ncdc::correct {raw picture {source 0} {target ""}} {
    variable service
    variable memory
    variable lenses
    variable lens
    variable counted
    if {$lens eq ""} {
        error "no lens is loaded, there are [join [dict keys $lenses] {, }]"
    }
    if {[field CAPABILITIES STREAM]} {
        error "this corrector's pictures leave as a stream: none is in memory"
    }
    set one [dict get $lenses $lens]
    set padded [rows $raw $one]
    if {$target eq ""} {
        set target [expr {($source + [dict get $one source_bytes] + 4095) / 4096 * 4096}]
    }
    if {[catch {
        master_write_from_file $service $padded [format 0x%08x [expr {$memory + $source}]]
    } said]} {
        file delete $padded
        error $said
    }
    file delete $padded
    free
    put SOURCE_BASE $source
    put SOURCE_LIMIT [expr {$source + [dict get $one source_bytes]}]
    put TARGET_BASE $target
    put TARGET_LIMIT [expr {$target + [dict get $one target_bytes]}]
    taken
    put CTRL [expr {[flag CTRL COMMIT] | [flag CTRL START]}]
    wait
    set stored [file normalize $picture.stored]
    master_read_to_file $service $stored [format 0x%08x [expr {$memory + $target}]] \
        [dict get $one target_bytes]
    ppm $stored $picture $one
    file delete $stored
    set size "[dict get $one width]x[dict get $one height]"
    # A corrector without counters counts no clocks.
    return "$picture: $size[expr {"CLOCKS" in $counted ? ", [get CLOCKS] clocks" : ""}]"
}

# Counters of the last frame.
proc ncdc::counters {} {
    variable counted
    foreach name $counted {
        lappend found $name [get $name]
    }
    return $found
}

# Write a file with the corrector's row pitch from one with or without gaps between rows.
proc ncdc::rows {path one} {
    lassign [list [dict get $one raw_width] [dict get $one raw_height]] width height
    set pitch [dict get $one values SOURCE_PITCH]
    set data [contents $path]
    set size [string length $data]
    if {$size != $width * $height && $size != $pitch * $height} {
        error "$path has $size bytes, a raw frame of ${width}x$height has [expr {$width * $height}]"
    }
    set row [expr {$size / $height}]
    set padded [file normalize $path.padded]
    set file [open $padded wb]
    for {set k 0} {$k < $height} {incr k} {
        puts -nonewline $file [binary format a$pitch [string range $data [expr {$k * $row}] \
            [expr {$k * $row + $row - 1}]]]
    }
    puts -nonewline $file [binary format x[expr {
        max(0, [dict get $one source_bytes] - $pitch * $height)}]]
    close $file
    return $padded
}

# Pixels in memory to red, green, blue.
proc ncdc::ppm {stored picture one} {
    set step [dict get $one pixel_bytes]
    binary scan [contents $stored] cu* bytes
    set out {}
    if {$step == 1} {
        foreach grey $bytes {
            lappend out $grey $grey $grey
        }
    } elseif {$step == 3} {
        foreach {blue green red} $bytes {
            lappend out $red $green $blue
        }
    } else {
        foreach {blue green red zero} $bytes {
            lappend out $red $green $blue
        }
    }
    set file [open $picture wb]
    puts -nonewline $file "P6 [dict get $one width] [dict get $one height] 255\n"
    puts -nonewline $file [binary format c* $out]
    close $file
}

proc ncdc::contents {path} {
    set file [open $path rb]
    set data [read $file]
    close $file
    return $data
}

# Error if a commit waits: it must not be overwritten.
proc ncdc::free {} {
    if {[field STATUS COMMITTED]} {
        error "a commit waits for its frame boundary: nothing was written"
    }
}

# Error if a write was rejected.
proc ncdc::taken {} {
    if {[field STATUS REFUSED]} {
        put STATUS [flag STATUS REFUSED]
        error "the corrector rejected a write"
    }
}

# Wait until a frame is complete: JTAG is slow, so that a few polls are enough.
proc ncdc::wait {{polls 1000}} {
    variable flags
    for {set k 0} {![field STATUS DONE]} {incr k} {
        if {$k >= $polls} {
            error "no frame is complete after $polls reads of STATUS"
        }
    }
    set status [get STATUS]
    put STATUS [flag STATUS DONE]
    if {$status & [flag STATUS FAULT]} {
        set found [get FAULT]
        put FAULT $found
        set names {}
        dict for {name mask} $flags {
            if {[string match FAULT_* $name] && ($found & $mask)} {
                lappend names [string range $name 6 end]
            }
        }
        error "the corrector rejected: [join $names {, }]"
    }
    if {$status & [flag STATUS ABORTED]} {
        error "the frame was aborted"
    }
}

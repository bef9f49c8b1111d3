# Quartus's programs at the cable, with a board's registers: System Console's commands for
# a host, and those of ::quartus::jtag for a device's JTAG. Runs what comes at standard input,
# and repeats it.
array set words {}
proc word {address} {
    global words
    return [expr {[info exists words($address)] ? $words($address) : 0}]
}

proc get_service_paths {kind} { return /devices/jtag_0 }
proc claim_service {kind path library} { return /channels/local/$library }
proc master_read_32 {service address count} {
    return [format 0x%08x [word [expr {$address - 0x10000000}]]]
}
proc master_write_32 {service address value} {
    global words
    set words([expr {$address - 0x10000000}]) [expr {$value}]
}

# The chain: an answer comes with the second scan after its request, as its clock stops between.
set state closed
set waiting {}
proc get_hardware_names {} { return [list {USB-BlasterII [1-2]}] }
proc get_device_names {option cable} {
    if {$option ne "-hardware_name" || $cable eq ""} { error "no such cable" }
    return [list {@1: SOCVHPS (0x4BA00477)} {@2: 5CSEBA5(.|ES)/5CSEMA5 (0x02D120DD)}]
}
proc open_device {a cable b device} {
    if {![string match @2:* $device]} { error "this is no FPGA: $device" }
    set ::state open
}
proc device_lock {option ms} { set ::state locked }
proc device_unlock {} { set ::state open }
proc close_device {} { set ::state closed }
proc device_virtual_ir_shift {args} {
    if {$::state ne "locked" || [dict get [lrange $args 0 3] -ir_value] != 1} { error "IR" }
}
proc device_virtual_dr_shift {args} {
    global words waiting
    if {[lindex $args end] ne "-value_in_hex" || $::state ne "locked"} { error "DR" }
    set options [lrange $args 0 end-1]
    if {[dict get $options -length] != 64} { error "length" }
    set out [lindex $waiting 0]
    if {$out eq {}} { set out 0000000000000000 }
    set waiting [lrange $waiting 1 end]
    set value [dict get $options -dr_value]
    scan $value %2x%2x%4x%8x kind tag address word
    if {$kind == 2} { set words([expr {4 * $address}]) $word }
    if {$kind == 1} { set word [word [expr {4 * $address}]] }
    if {$kind != 0 && $address < 0x8000} {
        set waiting [list 0000000000000000 [format %02X%02X%04X%08X $kind $tag \
            $address [expr {$word & 0xFFFFFFFF}]]]
    }
    return $out
}

while {[gets stdin line] >= 0} {
    puts "tcl> $line"
    eval $line
    flush stdout
}

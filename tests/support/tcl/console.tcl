# System Console's commands for a host, as lines to whoever started this:
#     tclsh console.tcl ncdc_console.tcl script
proc ask {args} {
    puts "ASK $args"
    flush stdout
    return [gets stdin]
}
proc get_service_paths {kind} {
    return [expr {$kind eq "master" ? "/devices/jtag_0" : {}}]
}
proc claim_service {kind path library args} {
    if {$kind ne "master" || $path ne "/devices/jtag_0"} {
        error "no $kind $path"
    }
    return /channels/local/$library
}
proc check {service} {
    if {![string match /channels/local/* $service]} {
        error "service $service was not claimed"
    }
}
proc close_service {kind service} {
    check $service
}
# A list of words, each with eight digits.
proc master_read_32 {service address count} {
    check $service
    for {set k 0} {$k < $count} {incr k} {
        lappend words [format 0x%08x [ask read [expr {$address + 4 * $k}]]]
    }
    return $words
}
proc master_write_32 {service address words} {
    check $service
    foreach word $words {
        ask write [expr {$address}] [expr {$word}]
        incr address 4
    }
}
proc master_write_from_file {service path address} {
    check $service
    ask from $path [expr {$address}]
}
proc master_read_to_file {service path address count} {
    check $service
    ask to $path [expr {$address}] [expr {$count}]
}
lassign $argv script commands
source $script
if {[catch {source $commands} said]} {
    puts "SAID $said"
}

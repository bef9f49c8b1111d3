/* The network: what comes is GVCP's, or that of the protocols below it. */
#ifndef NET_H
#define NET_H

void net_begin(void);
void net_poll(void);

#endif

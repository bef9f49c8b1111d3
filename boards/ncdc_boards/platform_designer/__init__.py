"""Projects around a corrector in Platform Designer, for boards whose memory is the user's."""

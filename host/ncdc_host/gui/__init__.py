"""The window of the client, with Qt: ``ncdc client gui``.

``session.py`` and ``receiver.py`` talk to devices, in threads of their own, and know no widgets;
the widgets know no devices, only a :class:`~ncdc_host.gui.session.Session`.
"""

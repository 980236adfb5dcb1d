"""The contract between a NAO and its controller: data sheet, messages, Zenoh link, safety guard."""
